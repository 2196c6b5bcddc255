// Errors, versions, and directions as observers give them; then tables.
#include <stratus/base/direction.h>
#include <stratus/table/lookup.h>

#include "handles.h"

#include <cstdio>
#include <utility>

namespace {

thread_local char last_error[1000] = "";

}  // namespace

int stratus::c::failed(int status, const char* what) noexcept {
    std::snprintf(last_error, sizeof last_error, "%s", what);
    return status;
}

void stratus::c::refuse_null(const char* function, const char* argument) {
    throw std::invalid_argument(std::string(function) + ": " + argument +
                                " must be given, got null");
}

const char* stratus_last_error(void) { return last_error; }

const char* stratus_version(void) { return STRATUS_VERSION; }

int stratus_abi_version(void) { return STRATUS_ABI_VERSION; }

using namespace stratus;
using namespace stratus::c;

int stratus_observed_direction(double incidence_deg, double emission_deg, double phase_deg,
                               double* mu_in, double* mu_out, double* azimuth, int* transmitted) {
    return run_guarded(
        __func__,
        {{mu_in, "mu_in"}, {mu_out, "mu_out"}, {azimuth, "azimuth"}, {transmitted, "transmitted"}},
        [&, function = __func__] {
            const auto [at, side] =
                observed_geometry({incidence_deg, emission_deg, phase_deg}, function);
            *mu_in = at.mu_in;
            *mu_out = at.mu_out;
            *azimuth = at.azimuth;
            *transmitted = side == Side::transmission ? 1 : 0;
        });
}

// Tables: opened, described, looked up.

namespace stratus::c {

SharedTable::SharedTable(AnyTable table) : own(std::move(table)) {
    const Table& of = own.table();
    phase_function = of.phase_function.text();
    if (mixes_two(of.family)) second_phase_function = of.second_phase_function.text();
    layer_texts.reserve(of.layers.size());  // which are pointed to
    for (const StackLayer& layer : of.layers)
        layers.push_back({layer_texts.emplace_back(layer.phase_function.text()).c_str(),
                          layer.albedo, layer.optical_depth});
}

std::unique_lock<std::mutex> hdf5_lock() {
    static std::mutex hdf5;
    return std::unique_lock(hdf5);
}

StackLayers make_layers(const stratus_layer* layers, std::size_t count, const char* function) {
    require(count > 0, function, "layer_count", "at least 1", count);
    require_given(function, {{layers, "layers"}});
    StackLayers all;
    for (std::size_t i = 0; i < count; ++i) {
        require_given(function, {{layers[i].phase_function, "phase_function of every layer"}});
        all.push_back({read_phase_function(layers[i].phase_function), layers[i].albedo,
                       layers[i].optical_depth});
    }
    return all;
}

void require_member(const stratus_table& table, const char* function) {
    require(!table.view.has_family() || table.view.chosen.size() > 0, function, "table",
            "of one point of its family, by stratus_table_at()", "one of the whole family");
}

stratus_table* make_handle(AnyTable table) {
    auto shared = std::make_shared<const SharedTable>(std::move(table));
    return new stratus_table{shared, shared->own.view()};
}

namespace {

stratus_range to_range(const Axis& axis) {
    if (axis.values.empty()) return {0, 0, 0};
    return {axis.values.front(), axis.values.back(), axis.values.size()};
}

constexpr std::size_t first_info_size = offsetof(stratus_table_info, mixture);

/// R or T of a table at many points.
int look_up_points(const stratus_table* table, Side side, std::size_t count,
                   const stratus_point* points, stratus_scattered* values,
                   const char* function) noexcept {
    return run_guarded(function, {{table, "table"}}, [&] {
        require_member(*table, function);
        if (count == 0) return;
        require_given(function, {{points, "points"}, {values, "values"}});
        for (std::size_t i = 0; i < count; ++i) {
            const stratus_point& at = points[i];
            const Scattered found = scattering(table->view, side, at.albedo, at.optical_depth,
                                               {at.mu_in, at.mu_out, at.azimuth});
            values[i] = {found.single, found.multiple};
        }
    });
}

/// Totals of a packed table.
int look_up_arrays(const stratus_table* table, Side side, const PackedPoints& points, float* total,
                   const char* function) noexcept {
    return run_guarded(function, {{table, "table"}}, [&] {
        require_member(*table, function);
        const PackedTable* const packed = table->shared->own.packed();
        require(packed != nullptr, function, "table", "a packed one", "one with samples");
        require_arrays(points.count,
                       {points.optical_depth, points.albedo, points.mu_in, points.mu_out,
                        points.azimuth, total},
                       function);
        if (points.count == 0) return;
        const bool has_family = table->view.has_family();
        require(!has_family || is_mixture(*table->view.family), function, "table",
                "of one phase function, or mixtures of two", "of a family");
        packed->scattering(side, points, total, has_family ? table->view.chosen_mixture : 1);
    });
}

}  // namespace
}  // namespace stratus::c

int stratus_table_open(const char* path, stratus_table** table) {
    return make_guarded(__func__, table, "table", {{path, "path"}}, [&] {
        const std::unique_lock lock = hdf5_lock();
        return make_handle(read_any_table(path));
    });
}

int stratus_table_open_memory(const void* data, size_t bytes, stratus_table** table) {
    return make_guarded(__func__, table, "table", {{data, "data"}},
                        [&] { return make_handle(PackedTable(data, bytes)); });
}

int stratus_table_at(const stratus_table* table, size_t count, const double* values,
                     stratus_table** chosen) {
    return make_guarded(__func__, chosen, "chosen", {{table, "table"}}, [&, function = __func__] {
        if (count > 0) require_given(function, {{values, "values"}});
        const TableView whole = table->shared->own.view();
        return new stratus_table{table->shared, whole.at(FamilyPoint({values, values + count}))};
    });
}

int stratus_table_family(const stratus_table* table, size_t axis, const char** name,
                         stratus_range* range) {
    const char* const function = __func__;
    return run_guarded(function, {{table, "table"}, {name, "name"}, {range, "range"}}, [&] {
        const auto& family = table->shared->own.table().family;
        require(axis < family.size(), function, "axis", "below " + std::to_string(family.size()),
                axis);
        *name = family[axis].name();
        *range = to_range(family[axis].axis);
    });
}

void stratus_table_close(stratus_table* table) { delete table; }

int stratus_table_describe(const stratus_table* table, stratus_table_info* info) {
    return run_guarded(__func__, {{table, "table"}, {info, "info"}}, [&, function = __func__] {
        require_size(*info, function, "info", first_info_size);
        const Table& of = table->shared->own.table();
        stratus_table_info found{};
        found.optical_depth = to_range(of.optical_depth);
        found.albedo = to_range(of.albedo);
        found.mu_in = to_range(of.mu_in);
        found.mu_out = to_range(of.mu_out);
        found.azimuth = to_range(of.azimuth);
        found.has_reflection = table->view.has_reflection();
        found.has_transmission = table->view.has_transmission();
        found.has_lower_boundary = table->view.has_lower_boundary();
        found.highest_order = of.highest_order;
        found.tolerance = of.tolerance;
        found.measured_error = of.measured_error;
        if (of.has_family() && is_mixture(of.family)) found.mixture = to_range(of.family[0].axis);
        found.is_packed = table->shared->own.packed() != nullptr;
        found.is_stack = of.is_stack();
        fill(*info, found);
    });
}

const char* stratus_table_text(const stratus_table* table, const char* name) {
    if (table == nullptr || name == nullptr) return nullptr;
    const SharedTable& of = *table->shared;
    if (std::strcmp(name, "phase_function") == 0) return of.phase_function.c_str();
    if (std::strcmp(name, "second_phase_function") == 0)
        return of.second_phase_function.empty() ? nullptr : of.second_phase_function.c_str();
    for (const auto& [known, text] : of.own.table().attributes)
        if (known == name) return text.c_str();
    return nullptr;
}

const stratus_layer* stratus_table_layers(const stratus_table* table, size_t* count) {
    const bool is_stack = table != nullptr && !table->shared->layers.empty();
    if (count != nullptr) *count = is_stack ? table->shared->layers.size() : 0;
    return is_stack ? table->shared->layers.data() : nullptr;
}

int stratus_table_reflection(const stratus_table* table, size_t count, const stratus_point* points,
                             stratus_scattered* values) {
    return look_up_points(table, Side::reflection, count, points, values, __func__);
}

int stratus_table_transmission(const stratus_table* table, size_t count,
                               const stratus_point* points, stratus_scattered* values) {
    return look_up_points(table, Side::transmission, count, points, values, __func__);
}

int stratus_table_reflection_many(const stratus_table* table, size_t count,
                                  const float* optical_depth, const float* albedo,
                                  const float* mu_in, const float* mu_out, const float* azimuth,
                                  float* total) {
    return look_up_arrays(table, Side::reflection,
                          {albedo, optical_depth, mu_in, mu_out, azimuth, count}, total, __func__);
}

int stratus_table_transmission_many(const stratus_table* table, size_t count,
                                    const float* optical_depth, const float* albedo,
                                    const float* mu_in, const float* mu_out, const float* azimuth,
                                    float* total) {
    return look_up_arrays(table, Side::transmission,
                          {albedo, optical_depth, mu_in, mu_out, azimuth, count}, total, __func__);
}
