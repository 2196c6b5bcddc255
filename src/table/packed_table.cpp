#include <stratus/table/packed_table.h>

#include <stratus/base/argument.h>
#include <stratus/base/size.h>
#include <stratus/table/metadata.h>
#include <stratus/table/packed_block.h>

#include "base/mapped_tensors.h"
#include "layer_blend.h"
#include "lookup_arguments.h"
#include "packed_parts.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <new>
#include <stdexcept>
#include <string_view>
#include <utility>

namespace stratus {
namespace {

PackedPoint packed(const TablePoint& at) noexcept {
    return {static_cast<float>(at.albedo),
            static_cast<float>(1 - at.albedo),
            static_cast<float>(std::min(at.optical_depth, 1e30)),
            static_cast<float>(at.geometry.mu_in),
            static_cast<float>(at.geometry.mu_out),
            static_cast<float>(at.geometry.azimuth)};
}

Scattered at_one(const SideMemory& side, const TablePoint& at) noexcept {
    float single_multiple[2];
    side.kernel->one(side.view, packed(at), single_multiple);
    return {double{single_multiple[0]}, double{single_multiple[1]}};
}

void at_many(const PackedSide& side, const PackedKernel& kernel, const PackedPoints& points,
             float* total) noexcept {
    const std::size_t rest = points.count % points_at_once, whole = points.count - rest;
    kernel.many(side, points, whole, total);
    if (rest == 0) return;
    alignas(64) float copy[5][points_at_once], found[points_at_once];
    const float* const from[5] = {points.albedo, points.optical_depth, points.mu_in, points.mu_out,
                                  points.azimuth};
    for (int q = 0; q < 5; ++q) {
        std::fill(copy[q], copy[q] + points_at_once, 0.5f);
        std::copy(from[q] + whole, from[q] + points.count, copy[q]);
    }
    kernel.many(side, {copy[0], copy[1], copy[2], copy[3], copy[4], points_at_once}, points_at_once,
                found);
    std::copy(found, found + rest, total + whole);
}

/// A copy of the bytes of a file, aligned as files are.
std::shared_ptr<char> aligned_copy(const std::vector<char>& bytes) {
    constexpr std::align_val_t alignment{packed_alignment};
    std::shared_ptr<char> copy(
        static_cast<char*>(operator new(std::max<std::size_t>(1, bytes.size()), alignment)),
        [](char* memory) { operator delete(memory, alignment); });
    std::copy(bytes.begin(), bytes.end(), copy.get());
    return copy;
}

/// Refuses other files by name: those of samples are what is given most often in place of packed ones.
void require_packed(std::string_view file) {
    const char* const kind = file.substr(0, 8) == hdf5_magic  ? "an HDF5 file"
                             : file.substr(0, 4) == exr_magic ? "an OpenEXR file"
                                                              : "another kind of file";
    require(file.size() > tensor_header_start && file[tensor_header_start] == '{', packed_caller,
            "the file",
            "a packed table, which `stratus bake` writes and `stratus pack` makes of a table of "
            "samples",
            kind);
}

}  // namespace

struct PackedTable::Contents {
    std::shared_ptr<const void> owner;  // of the file; null: the caller
    std::string_view file;
    Table header;
    TableView view;  // of the header
    PathSheet own_sheet;
    std::vector<PerSide<SideMemory>> members;

    Contents(std::shared_ptr<const void> owner_, const void* data, std::size_t bytes)
        : owner(std::move(owner_)), file(static_cast<const char*>(data), bytes) {
        require_aligned(data, "the file");
        require_packed(file);
        const TensorFile tensors(data, bytes);
        header = packed_header(tensors);
        view = header.view();
        const PathSheetView sheet = path_sheet(tensors, header, own_sheet);
        for (std::size_t m = 0; m < header.member_count(); ++m)
            members.push_back(packed_member(tensors, header, m, sheet));
        require(holds(Side::reflection) || holds(Side::transmission), packed_caller, "file",
                "one that holds reflection or transmission", "neither");
    }

    bool holds(Side side) const { return members[0][side].no_functions.empty(); }

    /// 1 where there is no mixture, which is not looked at.
    double share_in_range(double mixture) const noexcept {
        return header.has_family() ? in_range("mixture", 0.0, 1.0, mixture) : 1;
    }

    /// The members around a mixture; other families have not-a-number for weights.
    FamilyStencil members_around(double share) const noexcept {
        if (!header.has_family()) return {};
        FamilyPoint point;
        if (is_mixture(header.family)) point = {share};
        return family_stencil(header.family, point);
    }

    /// Returns these members with their weights in the orders n >= 2 of a side.
    FamilyStencil weighed_members(Side side, const FamilyStencil& around, double albedo,
                                  double optical_depth) const noexcept {
        if (side == Side::reflection) return around;
        return transmitted_members(view, around, albedo, depth_in(view, optical_depth));
    }

    const SideMemory& side_memory(const FamilyStencil& around, int k, Side side) const noexcept {
        return members[size(around.member[k])][side];
    }

    /// All that leaves the far side meets a lower boundary.
    bool is_dark(Side side) const noexcept {
        return side == Side::transmission && header.lower_boundary.is_present();
    }

    Scattered one(Side side, const TablePoint& point, double mixture) const noexcept {
        return side == Side::reflection ? one<Side::reflection>(point, mixture)
                                        : one<Side::transmission>(point, mixture);
    }

    /// Compiled for each side: one function for both takes a sixth longer.
    template <Side side>
    Scattered one(const TablePoint& point, double mixture) const noexcept {
        const double share = share_in_range(mixture);
        if (point.is_unknown() || std::isnan(share))
            return {double{not_a_number}, double{not_a_number}};
        Scattered sum{};
        if (is_dark(side)) return sum;
        const FamilyStencil around = members_around(share);
        const FamilyStencil weighed =
            weighed_members(side, around, point.albedo, point.optical_depth);
        for (int k = 0; k < around.count; ++k) {
            if (around.weight[k] == 0) continue;
            const Scattered at = at_one(side_memory(around, k, side), point);
            sum.single += double{around.weight[k]} * at.single;
            sum.multiple += double{weighed.weight[k]} * at.multiple;
        }
        if (!header.is_stack()) return not_negative(sum);
        sum.single = stack_single_scattering(side, header.layers, point.geometry);
        if (header.lower_boundary.has_closed_form())
            sum.single += single_reflection_of_boundary(header.lower_boundary, point.optical_depth,
                                                        point.geometry);
        return not_negative(sum);
    }

    double multiple(Side side, const TablePoint& point,
                    const FamilyStencil& around) const noexcept {
        if (point.is_unknown()) return double{not_a_number};
        double sum = 0;
        if (is_dark(side)) return sum;
        const FamilyStencil weighed =
            weighed_members(side, around, point.albedo, point.optical_depth);
        for (int k = 0; k < around.count; ++k)
            if (around.weight[k] != 0)
                sum += double{weighed.weight[k]} *
                       at_one(side_memory(around, k, side), point).multiple;
        return sum;
    }

    void multiple(Side side, const PackedLayers& layers, const Geometry& geometry, double share,
                  double (&value)[3]) const noexcept {
        PackedPoint points[3];
        FamilyStencil weighed[3];
        const FamilyStencil around = members_around(share);
        for (int k = 0; k < 3; ++k) {
            const TablePoint point(layers.albedo[k], layers.optical_depth[k], geometry);
            value[k] = point.is_unknown() ? double{not_a_number} : 0.0;
            points[k] = packed(point);
            weighed[k] = weighed_members(side, around, point.albedo, point.optical_depth);
        }
        if (is_dark(side)) return;
        for (int m = 0; m < around.count; ++m) {
            if (around.weight[m] == 0) continue;
            const SideMemory& memory = side_memory(around, m, side);
            float found[3];
            memory.of_multiple->layers(memory.view, points, found);
            for (int k = 0; k < 3; ++k) value[k] += double{weighed[k].weight[m]} * double{found[k]};
        }
    }

    void many(Side side, const PackedPoints& points, float* total, double share) const noexcept {
        const auto point = [&](std::size_t n) {
            return TablePoint(
                double{points.albedo[n]}, double{points.optical_depth[n]},
                {double{points.mu_in[n]}, double{points.mu_out[n]}, double{points.azimuth[n]}});
        };
        const bool falls = header.has_family() && side == Side::transmission;
        if (is_dark(side) || header.is_stack() || falls) {
            for (std::size_t n = 0; n < points.count; ++n)
                total[n] = static_cast<float>(one(side, point(n), share).total());
            return;
        }
        if constexpr (lookups_are_checked)
            for (std::size_t n = 0; n < points.count; ++n) point(n);
        std::fill(total, total + points.count, 0.0f);
        const FamilyStencil around = members_around(share_in_range(share));
        for (int m = 0; m < around.count; ++m) {
            if (around.weight[m] == 0) continue;
            const SideMemory& memory = side_memory(around, m, side);
            constexpr std::size_t block = 256;
            float found[block];
            for (std::size_t first = 0; first < points.count; first += block) {
                const std::size_t count = std::min(block, points.count - first);
                at_many(memory.view, *memory.kernel,
                        {points.albedo + first, points.optical_depth + first, points.mu_in + first,
                         points.mu_out + first, points.azimuth + first, count},
                        found);
                for (std::size_t n = 0; n < count; ++n)
                    total[first + n] += around.weight[m] * found[n];
            }
        }
        for (std::size_t n = 0; n < points.count; ++n) total[n] = total[n] < 0 ? 0 : total[n];
    }
};

PackedTable::PackedTable(const std::string& path) {
    const auto file = std::make_shared<const MappedFile>(path);
    try {
        contents_ = std::make_unique<const Contents>(file, file->data(), file->bytes());
    } catch (const std::invalid_argument& error) {
        throw std::runtime_error(path + ": " + error.what());
    }
}

PackedTable::PackedTable(const void* data, std::size_t bytes)
    : contents_(std::make_unique<const Contents>(nullptr, data, bytes)) {}

PackedTable::PackedTable(const std::vector<char>& bytes) {
    const std::shared_ptr<char> copy = aligned_copy(bytes);
    contents_ = std::make_unique<const Contents>(copy, copy.get(), bytes.size());
}

PackedTable::PackedTable(PackedTable&&) noexcept = default;
PackedTable& PackedTable::operator=(PackedTable&&) noexcept = default;
PackedTable::~PackedTable() = default;

std::string_view PackedTable::file() const noexcept { return contents_->file; }

const Table& PackedTable::header() const noexcept { return contents_->header; }

TableView PackedTable::view() const noexcept {
    TableView view = contents_->view;
    view.packed = this;
    view.packed_reflection = has_reflection();
    view.packed_transmission = has_transmission();
    return view;
}

Scattered PackedTable::scattering(Side side, double albedo, double optical_depth,
                                  const Geometry& geometry, double mixture) const noexcept {
    return contents_->one(side, {albedo, optical_depth, geometry}, mixture);
}

double PackedTable::multiple(Side side, double albedo, double optical_depth,
                             const Geometry& geometry,
                             const FamilyStencil& members) const noexcept {
    return contents_->multiple(side, {albedo, optical_depth, geometry}, members);
}

void PackedTable::multiple(Side side, const PackedLayers& layers, const Geometry& geometry,
                           double mixture, double (&value)[3]) const noexcept {
    contents_->multiple(side, layers, geometry, contents_->share_in_range(mixture), value);
}

void PackedTable::scattering(Side side, const PackedPoints& points, float* total,
                             double mixture) const noexcept {
    contents_->many(side, points, total, mixture);
}

bool PackedTable::has_reflection() const noexcept { return contents_->holds(Side::reflection); }
bool PackedTable::has_transmission() const noexcept { return contents_->holds(Side::transmission); }

namespace {

/// The samples of a resampled axis that one of the table's own is a sum of.
struct ResampledPlaces {
    int first, count;
    float weight[stencil_size];

    ResampledPlaces(const Resampling& sampling, int sample)
        : first(sampling.is_same() ? sample : 0), count(sampling.is_same() ? 1 : sampling.to) {
        for (int i = 0; i < count; ++i)
            weight[i] = sampling.is_same()
                            ? 1.0f
                            : static_cast<float>(sampling.inverse().weight(i, sample));
    }
};

/// Rows of functions, already summed, of the pair of cosines (i, j).
const float* summed_row(const FunctionLayout& layout, const std::vector<float>& rows, int i,
                        int j) {
    const auto [low, high] = std::minmax({i, j});
    return &rows[size(layout.symmetric ? (high * (high + 7) / 2 + low) * layout.azimuth_rows
                                       : i * layout.row_step() + j * layout.column_step())];
}

}  // namespace

std::vector<float> PackedTable::layer(Side which, double albedo, double optical_depth,
                                      const FamilyStencil& members) const {
    const TableView& table = contents_->view;
    const FunctionLayout layout(table);
    const int ins = table.mu_in.count, outs = table.mu_out.count, azimuths = table.azimuth.count;
    const int mirrored = azimuths > 1 ? 1 : 0;
    std::vector<ResampledPlaces> in, out;
    for (int i = 0; i < ins; ++i) in.emplace_back(layout.mu_in, i);
    for (int j = 0; j < outs; ++j) out.emplace_back(layout.mu_out, j);
    std::vector<float> values(size(ins) * size(outs) * size(azimuths)), rows(layout.rows());
    const FamilyStencil weighed = contents_->weighed_members(which, members, albedo, optical_depth);
    for (int m = 0; m < members.count; ++m) {
        const SideMemory& memory = contents_->side_memory(members, m, which);
        if (members.weight[m] == 0 || !memory.no_functions.empty()) continue;
        PackedSide side = memory.view;  // without what is known in closed form
        side.path = {};
        side.phase = {};
        side.surface_albedo = side.boundary_quarter_albedo = 0;
        const bool fades = side.over_surface && optical_depth < double{side.min_depth};
        side.over_surface = false;
        memory.of_multiple->rows(side, packed({albedo, optical_depth, {1, 1, 0}}), rows.size(),
                                 rows.data());
        float* to = values.data();
        for (int i = 0; i < ins; ++i)
            for (int j = 0; j < outs; ++j, to += azimuths)
                for (int r = 0; r < in[size(i)].count; ++r)
                    for (int c = 0; c < out[size(j)].count; ++c) {
                        const ResampledPlaces &of_in = in[size(i)], &of_out = out[size(j)];
                        float share = weighed.weight[m] * of_in.weight[r] * of_out.weight[c];
                        if (fades)
                            share *= static_cast<float>(
                                share_of_thinnest(optical_depth, double{side.min_depth},
                                                  table.mu_in.value(i), table.mu_out.value(j)));
                        const float* const from =
                            summed_row(layout, rows, of_in.first + r, of_out.first + c) + mirrored;
                        for (int k = 0; k < azimuths; ++k) to[k] += share * from[k];
                    }
    }
    return values;
}

Table PackedTable::unpacked() const {
    Table table = contents_->header;
    table.attributes["samples"] = "evaluated";
    for (const Side side : both_sides) {
        if (!contents_->holds(side)) continue;
        std::vector<float>& samples =
            side == Side::reflection ? table.reflection_multiple : table.transmission_multiple;
        samples.reserve(table.sample_count());
        for (std::size_t m = 0; m < table.member_count(); ++m)
            for (const double albedo : table.albedo.values)
                for (const double depth : table.optical_depth.values) {
                    FamilyStencil one;
                    one.member[0] = static_cast<int>(m);
                    const std::vector<float> values = layer(side, albedo, depth, one);
                    const float* value = values.data();
                    for (const double in : table.mu_in.values)
                        for (const double out : table.mu_out.values) {
                            const double shares =
                                table.lower_boundary.is_present()
                                    ? 1
                                    : intercepted_share(depth, in) * intercepted_share(depth, out);
                            for (std::size_t k = 0; k < table.azimuth.values.size(); ++k)
                                samples.push_back(static_cast<float>(shares * double{*value++}));
                        }
                }
    }
    prepare(table);
    return table;
}

const PackedSide& PackedTable::side(Side side) const noexcept {
    return contents_->members[0][side].view;
}

bool PackedTable::is_intact() const { return TensorFile(file().data(), file().size()).is_intact(); }

}  // namespace stratus
