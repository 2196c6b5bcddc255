#include <stratus/stratus.h>

#include <stratus/io/phase_file.h>
#include <stratus/io/table_file.h>
#include <stratus/runtime/argument.h>
#include <stratus/runtime/bsdf.h>
#include <stratus/runtime/lookup.h>
#include <stratus/runtime/packed_table.h>
#include <stratus/runtime/slice.h>
#include <stratus/runtime/table.h>

#include <cstdio>
#include <cstring>
#include <filesystem>
#include <initializer_list>
#include <memory>
#include <mutex>
#include <new>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>

struct stratus_table {
    explicit stratus_table(const char* path)
        : own(opened(path)),
          table(std::holds_alternative<stratus::Table>(own)
                    ? std::get<stratus::Table>(own)
                    : std::get<stratus::PackedTable>(own).header()),
          view(std::holds_alternative<stratus::Table>(own)
                   ? table.view()
                   : std::get<stratus::PackedTable>(own).view()),
          phase_function(table.phase_function.text()) {
        stratus::require(!table.has_mixture(), path, "mixture", "no axis of the table: it is C++'s",
                         table.mixture.values.size());
    }
    stratus_table(const stratus_table&) = delete;  // the view points into the table

    std::variant<stratus::Table, stratus::PackedTable> own;
    const stratus::Table& table;  // of a packed one its header
    stratus::TableView view;
    std::string phase_function;

  private:
    static std::variant<stratus::Table, stratus::PackedTable> opened(const std::string& path) {
        if (std::filesystem::path(path).extension() == stratus::packed_ending)
            return stratus::PackedTable(path);
        return stratus::read_table(path);
    }
};

struct stratus_slice {
    std::variant<std::monostate, stratus::Slice, stratus::RgbSlice> own;  // nothing: a BSDF's
    const stratus::Slice* one = nullptr;  // one of the two, by channels
    const stratus::RgbSlice* three = nullptr;
};

struct stratus_bsdf {
    std::variant<std::monostate, stratus::Bsdf, stratus::RgbBsdf> own;
    stratus_slice slice;
};

namespace {

using stratus::require;

thread_local char last_error[1000] = "";

int failed(int status, const char* what) noexcept {
    std::snprintf(last_error, sizeof last_error, "%s", what);
    return status;
}

/// Runs a function of the interface: what it throws becomes a status and a text.
template <class Body>
int status_of(const Body& body) noexcept {
    try {
        body();
        return STRATUS_OK;
    } catch (const std::invalid_argument& error) {
        return failed(STRATUS_INVALID_ARGUMENT, error.what());
    } catch (const std::bad_alloc&) {
        return failed(STRATUS_OUT_OF_MEMORY, "out of memory");
    } catch (const std::exception& error) {
        return failed(STRATUS_FAILED, error.what());
    } catch (...) {
        return failed(STRATUS_FAILED, "unknown exception");
    }
}

void require_given(const void* pointer, const char* function, const char* argument) {
    if (pointer != nullptr) return;  // before any text is made
    require(false, function, argument, "given", "null");
}

template <class Struct>
void require_size(const Struct& met, const char* function, const char* argument) {
    require(met.size == sizeof(Struct), function, std::string(argument) + ".size",
            std::to_string(sizeof(Struct)), met.size);
}

bool switched(int value, const char* name) {
    require(value == 0 || value == 1, "stratus_effects", name, "0 or 1", value);
    return value == 1;
}

stratus::Opposition::Law law_of(int law) {
    using Law = stratus::Opposition::Law;
    switch (law) {
        case STRATUS_BLINN_OPPOSITION: return Law::blinn;
        case STRATUS_HAPKE_OPPOSITION: return Law::hapke;
        default:
            require(law == STRATUS_NO_OPPOSITION, "stratus_effects", "opposition",
                    "one of the laws, 0 to 2", law);
            return Law::none;
    }
}

stratus::Effects effects_of(const stratus_effects* asked, const char* function) {
    stratus::Effects effects;
    if (asked == nullptr) return effects;
    require_size(*asked, function, "effects");
    effects.single = switched(asked->single, "single");
    effects.multiple = switched(asked->multiple, "multiple");
    effects.reflection = switched(asked->reflection, "reflection");
    effects.transmission = switched(asked->transmission, "transmission");
    effects.density = asked->density;
    effects.opposition = {law_of(asked->opposition), asked->opposition_width,
                          asked->opposition_amplitude};
    return effects;
}

template <int channels>
stratus::Medium<channels> medium_of(const double* optical_depth, const double* albedo) {
    stratus::Medium<channels> medium;
    std::memcpy(medium.optical_depth, optical_depth, sizeof medium.optical_depth);
    std::memcpy(medium.albedo, albedo, sizeof medium.albedo);
    return medium;
}

/// Binds `scatterer`, a table with `outside` or a phase function.
template <class Scatterer, class... Outside>
stratus_slice* bound(const Scatterer& scatterer, int channels, const double* optical_depth,
                     const double* albedo, const stratus_effects* asked, const char* function,
                     Outside... outside) {
    require(channels == 1 || channels == 3, function, "channels", "1 or 3", channels);
    require_given(optical_depth, function, "optical_depth");
    require_given(albedo, function, "albedo");
    const stratus::Effects effects = effects_of(asked, function);
    auto slice = std::make_unique<stratus_slice>();
    if (channels == 1)
        slice->one = &slice->own.emplace<stratus::Slice>(
            scatterer, medium_of<1>(optical_depth, albedo), effects, outside...);
    else
        slice->three = &slice->own.emplace<stratus::RgbSlice>(
            scatterer, medium_of<3>(optical_depth, albedo), effects, outside...);
    return slice.release();
}

int bind_table(const stratus_table* table, int channels, const double* optical_depth,
               const double* albedo, const stratus_effects* effects, stratus_slice** slice,
               const char* function, stratus::OutsideTable outside) noexcept {
    return status_of([&] {
        require_given(slice, function, "slice");
        *slice = nullptr;
        require_given(table, function, "table");
        *slice = bound(table->view, channels, optical_depth, albedo, effects, function, outside);
    });
}

/// Calls `use` with the slice of either kind.
template <class Use>
auto with(const stratus_slice& slice, const Use& use) {
    return slice.one != nullptr ? use(*slice.one) : use(*slice.three);
}

void write(float from, float* value) { *value = from; }

void write(const stratus::Rgb& from, float* value) {
    value[0] = from.r;
    value[1] = from.g;
    value[2] = from.b;
}

/// Calls `use` with the BSDF of either kind.
template <class Use>
auto with(const stratus_bsdf& bsdf, const Use& use) {
    const auto* const one = std::get_if<stratus::Bsdf>(&bsdf.own);
    return one != nullptr ? use(*one) : use(std::get<stratus::RgbBsdf>(bsdf.own));
}

/// A lookup of a slice: `look_up` returns its value.
template <class LookUp>
int look_up_once(const stratus_slice* slice, float* value, const char* function,
                 const LookUp& look_up) noexcept {
    return status_of([&] {
        require_given(slice, function, "slice");
        require_given(value, function, "value");
        with(*slice, [&](const auto& of) { write(look_up(of), value); });
    });
}

/// R or T of a table at many points.
template <class LookUp>
int look_up_points(const stratus_table* table, std::size_t count, const stratus_point* points,
                   stratus_scattered* values, const char* function,
                   const LookUp& look_up) noexcept {
    return status_of([&] {
        require_given(table, function, "table");
        if (count == 0) return;
        require_given(points, function, "points");
        require_given(values, function, "values");
        for (std::size_t i = 0; i < count; ++i) {
            const stratus_point& at = points[i];
            const stratus::Scattered found = look_up(table->view, at.albedo, at.optical_depth,
                                                     {at.mu_in, at.mu_out, at.azimuth});
            values[i] = {found.single, found.multiple};
        }
    });
}

/// Arrays of `count`, which may be null when that is 0.
void require_arrays(std::size_t count, std::initializer_list<const void*> arrays,
                    const char* function) {
    if (count == 0) return;
    for (const void* array : arrays) require_given(array, function, "every array");
}

stratus_range range_of(const stratus::Axis& axis) {
    return {axis.values.front(), axis.values.back(), axis.values.size()};
}

}  // namespace

const char* stratus_last_error(void) { return last_error; }

const char* stratus_version(void) { return STRATUS_VERSION; }

int stratus_abi_version(void) { return STRATUS_ABI_VERSION; }

int stratus_table_open(const char* path, stratus_table** table) {
    const char* const function = __func__;
    return status_of([&] {
        require_given(table, function, "table");
        *table = nullptr;
        require_given(path, function, "path");
        static std::mutex hdf5;  // is not thread-safe
        const std::lock_guard lock(hdf5);
        *table = new stratus_table(path);
    });
}

void stratus_table_close(stratus_table* table) { delete table; }

int stratus_table_describe(const stratus_table* table, stratus_table_info* info) {
    const char* const function = __func__;
    return status_of([&] {
        require_given(table, function, "table");
        require_given(info, function, "info");
        require_size(*info, function, "info");
        const stratus::Table& of = table->table;
        info->optical_depth = range_of(of.optical_depth);
        info->albedo = range_of(of.albedo);
        info->mu_in = range_of(of.mu_in);
        info->mu_out = range_of(of.mu_out);
        info->azimuth = range_of(of.azimuth);
        info->has_reflection = table->view.has_reflection();
        info->has_transmission = table->view.has_transmission();
        info->has_lower_boundary = table->view.has_lower_boundary();
        info->highest_order = of.highest_order;
        info->tolerance = of.tolerance;
        info->measured_error = of.measured_error;
    });
}

const char* stratus_table_text(const stratus_table* table, const char* name) {
    if (table == nullptr || name == nullptr) return nullptr;
    if (std::strcmp(name, "phase_function") == 0) return table->phase_function.c_str();
    for (const auto& [known, text] : table->table.attributes)
        if (known == name) return text.c_str();
    return nullptr;
}

int stratus_table_reflection(const stratus_table* table, size_t count, const stratus_point* points,
                             stratus_scattered* values) {
    return look_up_points(table, count, points, values, __func__, stratus::reflection);
}

int stratus_table_transmission(const stratus_table* table, size_t count,
                               const stratus_point* points, stratus_scattered* values) {
    return look_up_points(table, count, points, values, __func__, stratus::transmission);
}

int stratus_effects_default(stratus_effects* effects) {
    const char* const function = __func__;
    return status_of([&] {
        require_given(effects, function, "effects");
        require_size(*effects, function, "effects");
        const stratus::Effects usual;
        *effects = {sizeof(stratus_effects), usual.single,           usual.multiple,
                    usual.reflection,        usual.transmission,     usual.density,
                    STRATUS_NO_OPPOSITION,   usual.opposition.width, usual.opposition.amplitude};
    });
}

int stratus_slice_bind(const stratus_table* table, int channels, const double* optical_depth,
                       const double* albedo, const stratus_effects* effects,
                       stratus_slice** slice) {
    return bind_table(table, channels, optical_depth, albedo, effects, slice, __func__,
                      stratus::OutsideTable::refuse);
}

int stratus_slice_bind_clamped(const stratus_table* table, int channels,
                               const double* optical_depth, const double* albedo,
                               const stratus_effects* effects, stratus_slice** slice) {
    return bind_table(table, channels, optical_depth, albedo, effects, slice, __func__,
                      stratus::OutsideTable::clamp);
}

int stratus_slice_bind_single(const char* phase_function, int channels, const double* optical_depth,
                              const double* albedo, const stratus_effects* effects,
                              stratus_slice** slice) {
    const char* const function = __func__;
    return status_of([&] {
        require_given(slice, function, "slice");
        *slice = nullptr;
        require_given(phase_function, function, "phase_function");
        *slice = bound(stratus::read_phase_function(phase_function), channels, optical_depth,
                       albedo, effects, function);
    });
}

void stratus_slice_free(stratus_slice* slice) { delete slice; }

int stratus_slice_channels(const stratus_slice* slice) {
    if (slice == nullptr) return 0;
    return slice->one != nullptr ? 1 : 3;
}

size_t stratus_slice_bytes(const stratus_slice* slice) {
    if (slice == nullptr) return 0;
    return with(*slice, [](const auto& of) { return of.bytes(); });
}

int stratus_slice_clamped(const stratus_slice* slice) {
    if (slice == nullptr) return 0;
    return with(*slice, [](const auto& of) { return of.clamped() ? 1 : 0; });
}

int stratus_slice_reflection(const stratus_slice* slice, float mu_in, float mu_out, float azimuth,
                             float* value) {
    return look_up_once(slice, value, __func__, [=](const auto& of) noexcept {
        return of.reflection(mu_in, mu_out, azimuth);
    });
}

int stratus_slice_transmission(const stratus_slice* slice, float mu_in, float mu_out, float azimuth,
                               float* value) {
    return look_up_once(slice, value, __func__, [=](const auto& of) noexcept {
        return of.transmission(mu_in, mu_out, azimuth);
    });
}

int stratus_slice_eval(const stratus_slice* slice, const float wi[3], const float wo[3],
                       float* value) {
    const char* const function = __func__;
    return look_up_once(slice, value, function, [=](const auto& of) {
        require_given(wi, function, "wi");
        require_given(wo, function, "wo");
        return of.eval({wi[0], wi[1], wi[2]}, {wo[0], wo[1], wo[2]});
    });
}

int stratus_slice_reflection_many(const stratus_slice* slice, size_t count, const float* mu_in,
                                  const float* mu_out, const float* azimuth, float* value) {
    const char* const function = __func__;
    return status_of([&] {
        require_given(slice, function, "slice");
        require_arrays(count, {mu_in, mu_out, azimuth, value}, function);
        with(*slice, [&](const auto& of) { of.reflection(count, mu_in, mu_out, azimuth, value); });
    });
}

int stratus_slice_transmission_many(const stratus_slice* slice, size_t count, const float* mu_in,
                                    const float* mu_out, const float* azimuth, float* value) {
    const char* const function = __func__;
    return status_of([&] {
        require_given(slice, function, "slice");
        require_arrays(count, {mu_in, mu_out, azimuth, value}, function);
        with(*slice,
             [&](const auto& of) { of.transmission(count, mu_in, mu_out, azimuth, value); });
    });
}

int stratus_slice_eval_many(const stratus_slice* slice, size_t count, const float* const wi[3],
                            const float* const wo[3], float* value) {
    const char* const function = __func__;
    return status_of([&] {
        require_given(slice, function, "slice");
        require_given(wi, function, "wi");
        require_given(wo, function, "wo");
        require_arrays(count, {wi[0], wi[1], wi[2], wo[0], wo[1], wo[2], value}, function);
        with(*slice, [&](const auto& of) { of.eval(count, wi, wo, value); });
    });
}

int stratus_slice_direct(const stratus_slice* slice, float mu, float* value) {
    return look_up_once(slice, value, __func__,
                        [=](const auto& of) noexcept { return of.direct(mu); });
}

int stratus_slice_background(const stratus_slice* slice, float mu, float* value) {
    return look_up_once(slice, value, __func__,
                        [=](const auto& of) noexcept { return of.background(mu); });
}

int stratus_slice_source_behind(const stratus_slice* slice, float mu, float* value) {
    return look_up_once(slice, value, __func__,
                        [=](const auto& of) noexcept { return of.source_behind(mu); });
}

int stratus_bsdf_build(stratus_slice** slice, stratus_bsdf** bsdf) {
    const char* const function = __func__;
    return status_of([&] {
        require_given(bsdf, function, "bsdf");
        *bsdf = nullptr;
        require_given(slice, function, "slice");
        require_given(*slice, function, "*slice");
        const std::unique_ptr<stratus_slice> given(std::exchange(*slice, nullptr));
        auto built = std::make_unique<stratus_bsdf>();
        if (given->one != nullptr)
            built->slice.one =
                &built->own.emplace<stratus::Bsdf>(std::get<stratus::Slice>(std::move(given->own)))
                     .slice();
        else
            built->slice.three =
                &built->own
                     .emplace<stratus::RgbBsdf>(std::get<stratus::RgbSlice>(std::move(given->own)))
                     .slice();
        *bsdf = built.release();
    });
}

void stratus_bsdf_free(stratus_bsdf* bsdf) { delete bsdf; }

const stratus_slice* stratus_bsdf_slice(const stratus_bsdf* bsdf) {
    return bsdf == nullptr ? nullptr : &bsdf->slice;
}

size_t stratus_bsdf_bytes(const stratus_bsdf* bsdf) {
    if (bsdf == nullptr) return 0;
    return with(*bsdf, [](const auto& of) { return of.bytes(); });
}

int stratus_bsdf_sample(const stratus_bsdf* bsdf, const float wi[3], const float random[3],
                        float wo[3], float* value, float* pdf) {
    const char* const function = __func__;
    return status_of([&] {
        require_given(bsdf, function, "bsdf");
        require_given(wi, function, "wi");
        require_given(random, function, "random");
        require_given(wo, function, "wo");
        require_given(value, function, "value");
        require_given(pdf, function, "pdf");
        with(*bsdf, [&](const auto& of) {
            const auto drawn = of.sample({wi[0], wi[1], wi[2]}, random[0], random[1], random[2]);
            wo[0] = drawn.wo.x;
            wo[1] = drawn.wo.y;
            wo[2] = drawn.wo.z;
            write(drawn.value, value);
            *pdf = drawn.pdf;
        });
    });
}

int stratus_bsdf_pdf(const stratus_bsdf* bsdf, const float wi[3], const float wo[3], float* pdf) {
    const char* const function = __func__;
    return status_of([&] {
        require_given(bsdf, function, "bsdf");
        require_given(wi, function, "wi");
        require_given(wo, function, "wo");
        require_given(pdf, function, "pdf");
        *pdf = with(*bsdf, [&](const auto& of) {
            return of.pdf({wi[0], wi[1], wi[2]}, {wo[0], wo[1], wo[2]});
        });
    });
}

int stratus_bsdf_albedo(const stratus_bsdf* bsdf, const float wi[3], float* reflected,
                        float* transmitted) {
    const char* const function = __func__;
    return status_of([&] {
        require_given(bsdf, function, "bsdf");
        require_given(wi, function, "wi");
        require_given(reflected, function, "reflected");
        require_given(transmitted, function, "transmitted");
        with(*bsdf, [&](const auto& of) {
            const auto shares = of.albedo(stratus::Vector{wi[0], wi[1], wi[2]});
            write(shares.reflected, reflected);
            write(shares.transmitted, transmitted);
        });
    });
}
