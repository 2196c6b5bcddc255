// A table as a web page to look at: a lit sphere, rings, a slab over ground and lobes, with sliders for the layer,
// the sun and the camera, and values under the pointer. Light scattered once stands beside all orders.
//
// One HTML file that needs no network. It draws by WebGL2, with the lookups that `stratus shader` writes
// (stratus/shader/shader.h); its own parts are the files of src/view.
#pragma once

#include <stratus/table/packed_table.h>

#include <string>

namespace stratus {

/// The page's text.
///
/// Errors   std::invalid_argument for a table of a family (table_at in stratus/table/member_and_ground.h makes one of a member), of
///          some directions or, over nothing, one side alone, or without finite optical depths.
std::string view_page(const PackedTable& table);

}  // namespace stratus
