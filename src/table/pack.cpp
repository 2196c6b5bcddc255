#include <stratus/table/packed_table.h>

#include <stratus/base/argument.h>
#include <stratus/base/number_text.h>
#include <stratus/base/size.h>
#include <stratus/base/tensor_file.h>
#include <stratus/table/metadata.h>
#include <stratus/table/packed_block.h>

#include "layer/reflected_curve.h"
#include "layer_blend.h"
#include "layer_sums.h"
#include "packed_parts.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace stratus {
namespace {

// Share of the tolerance by which rounding to halves may change the path law.
constexpr double rounding_share = 0.05, half_rounding = 1.0 / (1 << 12);

std::vector<Half> to_halves(const std::vector<float>& values) {
    std::vector<Half> halves;
    halves.reserve(values.size());
    for (const float value : values) halves.push_back(to_half(value));
    return halves;
}

template <class Number>
void append(const std::vector<Number>& more, std::vector<Number>& all) {
    all.insert(all.end(), more.begin(), more.end());
}

void add_curve(TensorWriter& file, const std::string& name, const PhaseCurve& curve) {
    if (curve.sample_count() == 0) return;  // its phase function tells
    const std::size_t width = size(curve.width());
    file.add(name, {curve.sample_count() / width, width}, curve.view().sample);
}

/// The blocks of members that share their functions: these under the name of the first member,
/// coefficients under that of each.
///
/// Memory   lets go of each of `pivots` once no more blocks, which it counts, are to be made of it.
void add_blocks(TensorWriter& file, LayerSums& sums, const FoundBlocks& found, Side side,
                std::map<int, int>& pivots) {
    const Table& table = sums.table();
    const TableView view = table.view();
    const bool takes_halves =
        std::all_of(found.blocks.begin(), found.blocks.end(), [&](const Candidate& block) {
            return block.half_error <= total_share * kept_tolerance(view);
        });
    const int depth_rows = std::max(stencil_size, view.optical_depth.count),
              albedo_rows = std::max(stencil_size, view.albedo.count);
    const TensorShape shape{found.blocks.size(), FunctionLayout(view).rows(), found.functions};
    const std::size_t numbers = shape[0] * shape[1] * shape[2];
    std::vector<Half> halves;  // functions over (block, row, function)
    std::vector<float> floats;
    halves.reserve(takes_halves ? numbers : 0);
    floats.reserve(takes_halves ? 0 : numbers);
    Vectors coefficients(size(found.members.count));
    std::vector<BlockFields> fields;
    std::vector<std::int32_t> block_of_cell(size(albedo_rows * depth_rows), 0);
    for (std::size_t index = 0; index < found.blocks.size(); ++index) {
        const auto& [albedo_cells, depth_cells, layers, basis, half_error, holds] =
            found.blocks[index];
        const PackedBlock block = packed_block(sums, layers, basis);
        for (const int pivot : basis.pivot)
            if (--pivots[layers.number[size(pivot)]] == 0)
                sums.full.erase(layers.number[size(pivot)]);
        // A place on the last sample belongs to the last cell; short axes are sampled again.
        const auto range_end = [](const SampleRange& cells, int samples) {
            return samples < stencil_size ? stencil_size
                                          : std::min(cells.first + cells.count + 1, samples);
        };
        for (int a = albedo_cells.first; a < range_end(albedo_cells, view.albedo.count); ++a)
            for (int d = depth_cells.first; d < range_end(depth_cells, view.optical_depth.count);
                 ++d)
                block_of_cell[size(a * depth_rows + d)] = static_cast<std::int32_t>(index);
        const auto row_count = [&](const std::vector<float>& rows) {
            return static_cast<std::int32_t>(rows.size() / found.functions);
        };
        fields.push_back({layers.albedos.first, row_count(block.coefficient[0]) / block.depths,
                          layers.depths.first, block.depths, layers.and_infinity ? 1 : 0,
                          row_count(coefficients[0])});
        if (takes_halves)
            append(to_halves(block.function), halves);
        else
            append(block.function, floats);
        for (std::size_t m = 0; m < coefficients.size(); ++m)
            append(block.coefficient[m], coefficients[m]);
    }
    const std::int32_t owner = found.members.first;
    const std::string prefix = side_prefix(table, size(owner), side);
    if (takes_halves)
        file.add(prefix + functions_name, shape, std::move(halves));
    else
        file.add(prefix + functions_name, shape, std::move(floats));
    file.add(prefix + blocks_name, {shape[0], block_field_count},
             reinterpret_cast<const std::int32_t*>(fields.data()));
    file.add(prefix + block_of_cell_name, {size(albedo_rows), size(depth_rows)}, block_of_cell);
    for (int m = owner; m <= found.members.last(); ++m) {
        const std::vector<float>& own = coefficients[size(m - owner)];
        const std::string member = side_prefix(table, size(m), side);
        file.add(member + coefficients_name, {own.size() / found.functions, found.functions}, own);
        if (m > owner) file.add(member + functions_of_name, {1}, std::vector{owner});
    }
}

/// One side of all members, or of the only one.
void add_side(TensorWriter& file, LayerSums& sums, const std::vector<FoundBlocks>& groups,
              Side side, std::map<int, int>& pivots) {
    for (const FoundBlocks& group : groups) add_blocks(file, sums, group, side, pivots);
    const Table& table = sums.table();
    const LowerBoundary& below = table.lower_boundary;
    if (side == Side::reflection && below.is_layer())
        for (std::size_t m = 0; m < table.member_count(); ++m)
            add_curve(file, side_prefix(table, m, side) + phase_name,
                      reflected_curve(phase_function_of_member(table, m), {}, &below));
}

void add_path_law(TensorWriter& file, const Table& table) {
    // Lookups of families evaluate it at the chosen parameters.
    if (!table.path_law || table.has_family()) return;
    const PathOrders& law = *table.path_law;
    const std::size_t orders = size(law.order_count() - 2), angles = size(2 * law.angle_count());
    const std::vector<float> samples(law.of_angle(0), law.of_angle(0) + angles * orders);
    if (half_rounding <= rounding_share * kept_tolerance(table.view()))
        file.add(path_orders_name, {angles, orders}, to_halves(samples));
    else
        file.add(path_orders_name, {angles, orders}, samples);
    file.set(path_offset_name, shortest_text(double{law.offset()}));
    file.set(path_deepest_name, shortest_text(law.deepest()));
    if (orders <= most_summed_orders) return;
    const int first = first_path_step(law, table.view());
    const PathSheet sheet = squared_path_sheet(law, first, table.highest_order);
    const std::size_t albedos = size(path_sheet_steps(law) + 1 - first);
    file.add(path_sheet_name, {albedos, sheet.sample_count() / albedos / 2 / angles, angles, 2},
             sheet.view().sample);
}

void add_family_axes(TensorWriter& file, const Table& table) {
    for (const FamilyAxis& of_family : table.family) {
        const std::string name = of_family.name();
        file.add(name, {of_family.axis.values.size()}, of_family.axis.values);
        file.set(name + scale_suffix, of_family.is_discrete
                                          ? discrete_scale_name
                                          : axis_scale_name(of_family.axis.scale));
    }
}

/// The entries of all formats, some of which a bake knows only once the samples are packed.
void set_metadata(TensorWriter& file, const Table& table) {
    for (const auto& [name, text] : table.attributes)
        require(!is_reserved(name), "pack", "an attribute's name",
                "one that the format does not reserve", name);
    for (const auto& [name, text] : shared_metadata(table)) file.set(name, text);
}

void add_header(TensorWriter& file, const Table& table) {
    set_metadata(file, table);
    file.set(format_name, packed_format);
    file.set(format_version_name, packed_format_version);
    add_family_axes(file, table);
    for (const AxisField& field : axis_fields) {
        const Axis& axis = table.*field.axis;
        file.add(field.name, {axis.values.size()}, axis.values);
        file.set(std::string(field.name) + scale_suffix, axis_scale_name(axis.scale));
    }
    const auto shape = [&](std::size_t rank) {
        TensorShape sizes{table.member_count()};
        for (std::size_t k = 0; k < rank; ++k)
            sizes.push_back((table.*axis_fields[k].axis).values.size());
        return sizes;
    };
    for (const SampleField& field : sample_fields)
        if (const std::vector<float>& flux = table.*field.samples; field.is_flux() && !flux.empty())
            file.add(field.name, shape(field.rank), flux);
    file.add(diffusion_exponent_name, shape(1), table.diffusion_exponent);
}

}  // namespace

std::vector<char> pack(const Table& table, LayerSamples& samples) {
    const TableView view = table.view();
    const PerSide<bool> sides{view.has_reflection(),
                              view.has_transmission() && view.optical_depth.count > 0};
    PerSide<LayerSums> sums =
        find_layer_sums(table, sides, sums_share * kept_tolerance(view), samples);
    const int members = static_cast<int>(table.member_count());
    PerSide<std::vector<FoundBlocks>> groups;
    PerSide<std::map<int, int>> pivots;
    for (const Side side : both_sides) {
        if (!samples.is_first_rank()) break;
        if (sides[side]) groups[side] = grouped_blocks(sums[side], {0, members});
        pivots[side] = pivot_layers(groups[side]);
        sums[side].values = sums[side].importance = {};  // blocks are found
    }
    samples.trim_memory();
    see_in_full(pivots, sums, samples);
    if (!samples.is_first_rank()) return {};
    TensorWriter file;
    add_header(file, table);
    add_path_law(file, table);
    if (!table.varies_parameters())
        for (std::size_t m = 0; m < table.member_count(); ++m)
            add_curve(file, member_prefix(table, m) + phase_name,
                      PhaseCurve(phase_function_of_member(table, m)));
    for (const Side side : both_sides) {
        if (sides[side]) add_side(file, sums[side], groups[side], side, pivots[side]);
        sums[side] = {};
    }
    samples.trim_memory();
    return file.finish();
}

namespace {

/// The samples that a table holds itself.
class HeldSamples : public LayerSamples {
  public:
    explicit HeldSamples(const Table& table) : table_(table), numbers_(table.view()) {}

    int in_full(std::vector<int> layers, const Use& use) override {
        const DirectionList all = numbers_.all();
        for (const int layer : layers) use_layer(layer, {all, all}, use);
        return int_size(layers);
    }

    void at(const PerSide<DirectionList>& directions, const Use& use) override {
        if (directions.reflection.empty() && directions.transmission.empty()) return;
        for (std::size_t layer = 0; layer < table_.layer_count(); ++layer)
            use_layer(static_cast<int>(layer), directions, use);
    }

  private:
    void use_layer(int layer, const PerSide<DirectionList>& at, const Use& use) const {
        for (const Side side : both_sides) {
            const std::vector<float>& samples = side == Side::reflection
                                                    ? table_.reflection_multiple
                                                    : table_.transmission_multiple;
            if (!samples.empty()) use(layer, side, picked(samples, layer, at[side]));
        }
    }

    /// Means of what is the same both ways round.
    std::vector<float> picked(const std::vector<float>& samples, int layer,
                              const DirectionList& at) const {
        const std::size_t ins = table_.mu_in.values.size(), outs = table_.mu_out.values.size(),
                          azimuths = table_.azimuth.values.size();
        const float* const first = &samples[size(layer) * ins * outs * azimuths];
        std::vector<float> values;
        values.reserve(at.size());
        for (const std::size_t there : numbers_.positions(at)) {
            const std::size_t in = there / azimuths / outs, out = there / azimuths % outs;
            const std::size_t back = (out * outs + in) * azimuths + there % azimuths;
            values.push_back(numbers_.is_symmetric() ? 0.5f * (first[there] + first[back])
                                                     : first[there]);
        }
        return values;
    }

    const Table& table_;
    DirectionNumbers numbers_;
};

}  // namespace

std::vector<char> pack(const Table& table) {
    for (const std::vector<float>* const samples :
         {&table.reflection_multiple, &table.transmission_multiple})
        require(samples->empty() || samples->size() == table.sample_count(), "pack", "samples",
                "as many as the axes say, " + std::to_string(table.sample_count()),
                samples->size());
    HeldSamples samples(table);
    return pack(table, samples);
}

std::vector<char> restated(std::string_view file, const Table& table) {
    const TensorFile read(file.data(), file.size());
    TensorWriter written;
    for (const auto& [key, text] : read.strings()) written.set(key, text);
    set_metadata(written, table);
    std::map<const void*, std::string> in_order;
    for (const auto& [name, tensor] : read.tensors()) in_order[tensor.data] = name;
    for (const auto& [address, name] : in_order) {
        if (fills_a_gap(name)) continue;
        const Tensor& tensor = read.tensor(name);
        written.refer(name, tensor.type, tensor.shape, tensor.data);
    }
    return written.finish();
}

}  // namespace stratus
