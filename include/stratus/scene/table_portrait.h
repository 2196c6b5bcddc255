// The content of a table's portrait: lobes are looked up, spheres rendered as scenes.
#pragma once

#include <stratus/picture/portrait.h>
#include <stratus/table/table.h>

namespace stratus {

/// The portrait of a prepared table; a table with a mixture axis is shown at the middle of it.
///
/// Range    tables whose mu_in and mu_out have the same axis.
/// Threads  renders on all.
Portrait make_portrait(const Table& table);

}  // namespace stratus
