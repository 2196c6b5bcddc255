// A table in half the memory, for lookups alone.
//
// Samples range from 1e-35 to 1e2, far beyond halves. What is stored is what lookups interpolate:
// samples times the weights of their depth, albedo and both cosines (TableView), which varies
// little within one (albedo, optical_depth), and times a power of two that puts the largest of
// these just below the largest half. What the lookup multiplies by is its inverse.
#pragma once

#include <stratus/runtime/half.h>
#include <stratus/runtime/table.h>

#include <vector>

namespace stratus {

struct HalfTable {
    Table table;  // without its samples, and with the weights that those below are to have
    std::vector<Half> reflection_multiple;
    std::vector<Half> transmission_multiple;

    /// View for lookups, valid while this table lives and is not changed.
    TableView view() const noexcept;
};

/// A prepared table with its samples as halves. Move the table in to free its floats side by side.
///
/// Accuracy each sample keeps 2^-11 of itself, and what is less than 2^-28 of the largest of its
///          depth and albedo becomes 0.
HalfTable halved(Table table);

}  // namespace stratus
