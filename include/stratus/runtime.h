// Stratus in a renderer: the one page to read. Everything named here is C++17, needs no other library,
// and is linked as stratus::runtime.
//
// A table is baked beforehand and looked up in one of three ways. From slowest to fastest:
//
//   reflection, transmission (table/lookup.h)   any layer, one lookup at a time
//   PackedTable (table/packed_table.h)          any layer at each pixel; maps its file, *.stratus
//   Slice, Bsdf (bsdf/slice.h, bsdf/bsdf.h)     one layer bound first; a Bsdf draws directions, too
//
// Further effects, density, opposition, a background, are chosen when a layer is bound: Effects
// (layer/effects.h). All values are R or T, of which a white Lambert surface has 1: BRDF = R / pi.
// eval() gives the BRDF itself. Constructors and `bind` throw; no lookup throws, allocates or locks.
//
//     const stratus::PackedTable table("saturn_rings.stratus");
//
//     stratus::Effects effects;
//     effects.density = 0.02;  // of the volume
//     const stratus::Bsdf bsdf(stratus::bind(table.view(), 1.5, 0.95, effects));  // depth, albedo
//
//     const stratus::Vector wi{0.6f, 0, 0.8f};  // to the light; z is the normal
//     const auto next = bsdf.sample(wi, u1, u2, u3);
//     if (next.pdf > 0) throughput *= next.value * std::abs(next.wo.z) / next.pdf;
//     const float beam = bsdf.slice().direct(wi.z);  // goes straight through: no part of the BSDF
//
// Tables of families (droplets of any size, say) are seen at a point first, table.view().at({10});
// table/family_member.h makes a table of its own at a point. Readers of other files
// (io/table_file.h) are linked as stratus::io. docs/runtime.md has costs and limits.
#pragma once

#include <stratus/bsdf/bsdf.h>
#include <stratus/bsdf/slice.h>
#include <stratus/layer/effects.h>
#include <stratus/table/lookup.h>
#include <stratus/table/packed_table.h>
