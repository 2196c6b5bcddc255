// The content of a table's portrait: lobes are looked up, spheres rendered as scenes.
#pragma once

#include <stratus/picture/portrait.h>
#include <stratus/table/table.h>

namespace stratus {

/// The portrait of a table, by its header and its lookups; a family is shown at its middle.
///
/// Range    tables whose mu_in and mu_out have the same axis.
/// Threads  renders on all.
Portrait make_portrait(const Table& header, const TableView& whole);

}  // namespace stratus
