#include <stratus/base/constants.h>
#include <stratus/io/table_file.h>
#include <stratus/io/write_options.h>

#include "row_name.h"
#include "sample_table.h"
#include "temporary_folder.h"

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <utility>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

namespace stratus::test {
namespace {

struct Case {
    const char* name;
    Shape shape;
    std::function<void(Table&)> change = [](Table&) {};

    Table table() const {
        Table changed = sample_table(shape);
        change(changed);
        return changed;
    }
};

/// Several chunks of HDF5 and several blocks of rows of OpenEXR, of uneven sizes.
constexpr Shape several_chunks{
    .albedos = 7, .finite_depths = 12, .cosines_in = 13, .cosines_out = 13, .azimuths = 17};

std::string long_text(std::size_t length) {
    std::string text;
    for (std::size_t i = 0; text.size() < length; ++i) text += std::to_string(i * i) + '\n';
    return text;
}

Shape one_sided_mixtures() {
    Shape shape = several_chunks;
    shape.mixtures = 2;
    shape.transmission = false;
    return shape;
}

void remove_fluxes(Table& table) {
    table.plane_albedo.clear();
    table.spherical_albedo.clear();
}

void add_long_attributes(Table& table) {
    table.attributes["recipe"] = long_text(200'000);
    table.attributes["resolved_recipe"] = long_text(65'530);
    for (int i = 0; i < 40; ++i) table.attributes["note " + std::to_string(i)] = long_text(100);
}

void add_names_used_by_hdf5_and_exr(Table& table) {
    for (const char* name : {"name", "type", "channels", "dataWindow", "albedo", "CLASS", "NAME",
                             "_FillValue", "comments"})
        table.attributes[name] = name;
}

void use_tabulated_phase_function(Table& table) {
    table.phase_function = PhaseFunction::sum(
        {{0.3, PhaseFunction::tabulated({0, 10, 60, 130, 180}, {3.5, 2.0 / 3, 0.5, 0.3, 0.1})},
         {0.6, PhaseFunction::from_moments({1, 0.4, 1.0 / 7})}});
}

void use_extreme_numbers(Table& table) {
    table.reflection_multiple[0] = -0.0F;
    table.reflection_multiple[1] = std::numeric_limits<float>::denorm_min();
    table.reflection_multiple[2] = std::numeric_limits<float>::max();
    table.measured_error = std::numeric_limits<double>::denorm_min();
}

void clear_reflection(Table& table) {
    table.reflection_multiple.assign(table.reflection_multiple.size(), 0.0F);
}

void put_on_ground(Table& table) { table.lower_boundary = LowerBoundary::surface(1.0 / 3); }

void put_on_dust(Table& table) {
    table.lower_boundary = LowerBoundary::layer(
        PhaseFunction::sum({{1, PhaseFunction::tabulated({0, 90, 180}, {3.5, 2.0 / 3, 0.1})}}),
        0.1 + 0.2);
}

void put_on_ocean(Table& table) {
    table.lower_boundary = LowerBoundary::ground(read_ground_law("ocean:wind=5"));
}

void take_other_scales(Table& table) {
    table.azimuth =
        make_axis(AxisScale::square_root, 0, pi, static_cast<int>(table.azimuth.values.size()));
    table.albedo =
        make_axis(AxisScale::fourth_root_of_complement, table.albedo.values.front(),
                  table.albedo.values.back(), static_cast<int>(table.albedo.values.size()));
}

void narrow_directions(Table& table) {
    table.mu_in =
        make_axis(table.mu_in.scale, 0.2, 0.3, static_cast<int>(table.mu_in.values.size()));
    table.azimuth =
        make_axis(AxisScale::linear, 1.0 / 3, 1, static_cast<int>(table.azimuth.values.size()));
}

constexpr Shape six_members{.mixtures = 6}, reflection_only{.transmission = false};

/// One or two axes over parameters in place of the mixtures.
void take_family(Table& table, std::vector<FamilyAxis> axes) {
    table.family = std::move(axes);
    table.extrapolation_lengths.clear();
    for (std::size_t m = 0; m < table.member_count(); ++m)
        table.extrapolation_lengths.push_back(1 + static_cast<double>(m) / 7);
}

void make_lobes(Table& table) {
    table.phase_function = PhaseFunction::henyey_greenstein(0.5);
    table.second_phase_function = {};
    take_family(table, {{PhaseParameter::g,
                         make_axis(AxisScale::logarithm_of_complement, -0.2, 0.7, 6), false}});
}

void make_droplets(Table& table) {
    make_lobes(table);
    table.phase_function = parse_phase_function("mie:radius=0.3um");
    take_family(table,
                {{PhaseParameter::radius, make_axis(AxisScale::logarithmic, 0.2, 0.4, 3), false},
                 {PhaseParameter::wavelength, {AxisScale::logarithmic, {0.45, 0.65}}, true}});
}

void make_peaked_mixtures(Table& table) {
    table.phase_function = PhaseFunction::henyey_greenstein(0.9);
    take_family(table, {{PhaseParameter::g, {AxisScale::logarithm_of_complement, {0.5, 0.9}}, true},
                        {PhaseParameter::mixture, make_axis(AxisScale::linear, 0.5, 1, 3), false}});
}

/// Lookups add the path law.
void make_peaked_lobes(Table& table) {
    make_lobes(table);
    table.path_law =
        std::make_shared<const PathOrders>(PathLaw(significant_moments(table.phase_function)));
}

const std::vector<Case> cases{
    {"TwoSides", {}},
    {"ReflectionOnly", reflection_only},
    {"TransmissionOnly", {.reflection = false}},
    {"NoFluxes", reflection_only, remove_fluxes},
    {"OverASurface", reflection_only, put_on_ground},
    {"OverASemiInfiniteLayer", reflection_only, put_on_dust},
    {"OverAnOcean", reflection_only, put_on_ocean},
    {"FiniteDepths", {.infinite_depth = false}},
    {"InfiniteDepthOnly", {.finite_depths = 0}},
    {"SingleSamples",
     {.albedos = 1,
      .finite_depths = 1,
      .infinite_depth = false,
      .cosines_in = 1,
      .cosines_out = 1,
      .azimuths = 1}},
    {"SeveralChunks", several_chunks},
    {"LongAttributes", {}, add_long_attributes},
    {"NoAttributes", {}, [](Table& table) { table.attributes.clear(); }},
    {"NamesUsedByHdf5AndExr", {}, add_names_used_by_hdf5_and_exr},
    {"TabulatedPhaseFunction", {}, use_tabulated_phase_function},
    {"ExtremeNumbers", {}, use_extreme_numbers},
    {"AllZeros", several_chunks, clear_reflection},
    {"Mixtures", {.mixtures = 3}},
    {"Lobes", six_members, make_lobes},
    {"LobesWithPathLaw", six_members, make_peaked_lobes},
    {"Droplets", six_members, make_droplets},
    {"TwoAxesWithMixture", six_members, make_peaked_mixtures},
    {"SomeDirections", {}, narrow_directions},
    {"OtherScales", {}, take_other_scales},
    {"MixturesOfOneSide", one_sided_mixtures(), put_on_ground},
};

class RoundTrip : public testing::TestWithParam<Case> {
  protected:
    const Table table = GetParam().table();
    TemporaryFolder folder;
};

TEST_P(RoundTrip, ThroughBothFormatsIsExactAndGivesIdenticalFiles) {
    Table held = table;
    for (const char* name : {"a.h5", "b.exr", "c.h5", "d.exr"}) {
        SCOPED_TRACE(name);
        write_table(held, folder / name);
        held = read_table(folder / name);
        expect_same(held, table);
    }
    EXPECT_TRUE(content(folder / "a.h5") == content(folder / "c.h5"));
    EXPECT_TRUE(content(folder / "b.exr") == content(folder / "d.exr"));
}

INSTANTIATE_TEST_SUITE_P(Tables, RoundTrip, testing::ValuesIn(cases), row_name);

/// A chunk is half a megabyte: each side has several, the last of which are smaller.
TEST(TableFile, IsTheSameOnAnyNumberOfThreads) {
    const TemporaryFolder folder;
    Shape large;
    large.cosines_in = large.cosines_out = 70;
    large.azimuths = 9;
    const Table table = sample_table(large);
    write_table(table, folder / "one.h5", 1);
    for (const int threads : {2, 5, 0}) {
        write_table(table, folder / "many.h5", threads);
        EXPECT_TRUE(content(folder / "one.h5") == content(folder / "many.h5")) << threads;
    }
    expect_same(read_table(folder / "one.h5"), table);
}

/// Parts hold several albedos of the first, and some depths of one of the second.
TEST(TableFile, IsTheSameInWhateverOrderItsPartsAreDeflated) {
    const TemporaryFolder folder;
    Shape large = reflection_only;
    large.cosines_in = large.cosines_out = 70;
    large.azimuths = 9;
    for (const auto& [albedos, depths] : {std::pair{7, 4}, {2, 29}}) {
        large.albedos = albedos;
        large.finite_depths = depths;
        const Table table = sample_table(large);
        write_table(table, folder / "alone.h5");
        WriteOptions options;
        int count = 0;
        options.share = [&](const PartsToDeflate& parts) {
            count = parts.count;
            for (int part = count; part-- > 0;) {
                const std::vector<char> given = parts.give(part);
                EXPECT_LT(given.size(), most_bytes_of_part + 100);
                parts.take(part, deflate_part(given));
            }
        };
        write_table(table, folder / "shared.h5", options);
        EXPECT_EQ(count, albedos == 7 ? 2 : 4);
        EXPECT_TRUE(content(folder / "alone.h5") == content(folder / "shared.h5"));
    }
    EXPECT_THROW(deflate_part(std::vector<char>(7)), std::runtime_error);
    EXPECT_THROW(deflate_part(std::vector<char>(100)), std::runtime_error);
}

}  // namespace
}  // namespace stratus::test
