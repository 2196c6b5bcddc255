// Bound layers: R, T and BSDF values of one layer or three colours, and samples of its directions.
#include <stratus/base/constants.h>
#include <stratus/base/size.h>
#include <stratus/bsdf/any_slice.h>
#include <stratus/io/table_file.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "module.h"

namespace stratus::python {
namespace {

using Values = py::array_t<float>;

/// Directions that a narrowed table knows; all of any other.
struct KnownDirections {
    bool all = true;
    AxisView mu_in{}, mu_out{}, azimuth{};
};

struct Bound {
    AnySlice own;
    KnownDirections known;

    std::size_t channels() const { return size(own.channels()); }
};

// ---- binding ------------------------------------------------------------------------------------

Effects to_effects(const py::dict& asked) {
    Effects effects;
    const auto flag = [&](const char* name, bool& value) { value = asked[name].cast<bool>(); };
    flag("single", effects.single);
    flag("multiple", effects.multiple);
    flag("reflection", effects.reflection);
    flag("transmission", effects.transmission);
    flag("background", effects.background);
    effects.density = asked["density"].cast<double>();
    effects.opposition = make_opposition(asked["opposition"].cast<OppositionParts>());
    return effects;
}

Bound bind_table(const AnyTable& table, const std::vector<double>& optical_depth,
                 const std::vector<double>& albedo, const std::vector<double>& member, bool clamp,
                 bool sampled, const py::dict& asked) {
    const Effects effects = to_effects(asked);
    const TableView all = table.view();
    const TableView view = all.at(FamilyPoint(member));
    const KnownDirections known{view.has_all_directions(), view.mu_in, view.mu_out, view.azimuth};
    const OutsideTable outside = clamp ? OutsideTable::clamp : OutsideTable::refuse;
    const py::gil_scoped_release release;
    AnySlice slice = AnySlice::with_channels(albedo.size(), [&](auto count) {
        return SliceOf<count>(view, make_medium<count>(optical_depth.data(), albedo.data()),
                              effects, outside);
    });
    return {sampled ? std::move(slice).to_bsdf() : std::move(slice), known};
}

Bound bind_single(const PhaseFunction& phase_function, const std::vector<double>& optical_depth,
                  const std::vector<double>& albedo, const py::dict& asked) {
    const Effects effects = to_effects(asked);
    const py::gil_scoped_release release;
    return {AnySlice::with_channels(albedo.size(),
                                    [&](auto count) {
                                        return SliceOf<count>(
                                            phase_function,
                                            make_medium<count>(optical_depth.data(), albedo.data()),
                                            effects);
                                    })
                .to_bsdf(),
            {}};
}

// ---- lookups ------------------------------------------------------------------------------------

/// Vectors, or three numbers each: an array of (count, 3).
struct Vectors {
    std::size_t count;
    const float* components;

    explicit Vectors(const Floats& rows)
        : count(element_count(rows) / 3), components(rows.data()) {}

    Vector at(std::size_t i) const {
        return {components[3 * i], components[3 * i + 1], components[3 * i + 2]};
    }
};

Values empty(std::size_t rows, std::size_t count) {
    return Values({static_cast<py::ssize_t>(rows), static_cast<py::ssize_t>(count)});
}

/// Values over (channel, place) that fill(slice, values) finds while other Python threads run.
template <class Fill>
Values filled(const Bound& bound, std::size_t count, const Fill& fill) {
    Values values = empty(bound.channels(), count);
    float* const value = values.mutable_data();
    const py::gil_scoped_release release;
    bound.own.with_slice([&](const auto& slice) { fill(slice, value); });
    return values;
}

void put(float value, float* at, std::size_t) { *at = value; }

void put(const Rgb& value, float* at, std::size_t count) {
    at[0] = value.r;
    at[count] = value.g;
    at[2 * count] = value.b;
}

/// Zero too where `or_none`: sampling gives it for directions that scatter nothing.
void require_unit(const Vectors& vectors, const char* function, const char* argument,
                  bool or_none = false) {
    constexpr float margin = 1e-3f;
    for (std::size_t i = 0; i < vectors.count; ++i) {
        const auto [x, y, z] = vectors.at(i);
        const float squared = x * x + y * y + z * z;
        if (!(std::abs(squared - 1) <= margin || (or_none && squared == 0)))
            require(false, function, argument, or_none ? "of length 1 or 0" : "of length 1",
                    std::sqrt(squared));
    }
}

bool is_within(const AxisView& axis, double value) {
    constexpr double rounding = 1e-6;
    return value >= axis.lowest - rounding && value <= axis.highest + rounding;
}

void require_known(const KnownDirections& known, const char* function, double mu_in, double mu_out,
                   double azimuth) {
    const double folded = std::abs(std::remainder(azimuth, 2 * pi));
    require(is_within(known.mu_in, mu_in), function, "mu_in", "one that the table knows", mu_in);
    require(is_within(known.mu_out, mu_out), function, "mu_out", "one that the table knows",
            mu_out);
    require(
        (known.azimuth.count == 1 && known.azimuth.lowest == 0) || is_within(known.azimuth, folded),
        function, "azimuth", "one that the table knows", azimuth);
}

Values scattered(const Bound& bound, bool transmitted, const Floats& mu_in, const Floats& mu_out,
                 const Floats& azimuth) {
    const std::size_t count = element_count(mu_in);
    const float *in = mu_in.data(), *out = mu_out.data(), *angle = azimuth.data();
    return filled(bound, count, [&](const auto& slice, float* value) {
        const char* const function = transmitted ? "Slice.transmission" : "Slice.reflection";
        require_all(in, count, function, "mu_in", allowed_cosine);
        require_all(out, count, function, "mu_out", allowed_cosine);
        require_all(angle, count, function, "azimuth", allowed_angle);
        for (std::size_t i = 0; i < count && !bound.known.all; ++i)
            require_known(bound.known, function, double{in[i]}, double{out[i]}, double{angle[i]});
        slice.scattering(transmitted ? Side::transmission : Side::reflection, count, in, out, angle,
                         value);
    });
}

Values eval(const Bound& bound, const Floats& wi, const Floats& wo) {
    const Vectors in(wi), out(wo);
    return filled(bound, in.count, [&](const auto& slice, float* value) {
        require_unit(in, "Slice.eval", "wi");
        require_unit(out, "Slice.eval", "wo", true);
        for (std::size_t i = 0; i < in.count && !bound.known.all; ++i) {
            const auto [x_in, y_in, z_in] = in.at(i);
            const auto [x_out, y_out, z_out] = out.at(i);
            require_known(bound.known, "Slice.eval", std::abs(double{z_in}),
                          std::abs(double{z_out}),
                          std::atan2(double{y_out}, double{x_out}) -
                              std::atan2(-double{y_in}, -double{x_in}));  // 0 is the forward side
        }
        constexpr std::size_t piece = 512;
        float from[3][piece], to[3][piece], found[3 * piece];
        const float* const wis[] = {from[0], from[1], from[2]};
        const float* const wos[] = {to[0], to[1], to[2]};
        for (std::size_t first = 0; first < in.count; first += piece) {
            const std::size_t here = std::min(piece, in.count - first);
            for (std::size_t i = 0; i < here; ++i)
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    from[axis][i] = in.components[3 * (first + i) + axis];
                    to[axis][i] = out.components[3 * (first + i) + axis];
                }
            slice.eval(here, wis, wos, found);
            for (std::size_t c = 0; c < bound.channels(); ++c)
                std::copy_n(found + c * here, here, value + c * in.count + first);
        }
    });
}

/// direct, background or source_behind at cosines.
Values behind(const Bound& bound, const std::string& what, const Floats& cosines) {
    const std::size_t count = element_count(cosines);
    const float* const mu = cosines.data();
    return filled(bound, count, [&](const auto& slice, float* value) {
        require_all(mu, count, ("Slice." + what).c_str(), "mu", allowed_cosine);
        for (std::size_t i = 0; i < count; ++i)
            put(what == "direct"       ? slice.direct(mu[i])
                : what == "background" ? slice.background(mu[i])
                                       : slice.source_behind(mu[i]),
                value + i, count);
    });
}

// ---- sampling -----------------------------------------------------------------------------------

/// wo, value and pdf of directions drawn by `u`, three numbers for each of `wi`: all (count, 3).
py::tuple sample(const Bound& bound, const Floats& wi, const Floats& u) {
    const Vectors in(wi), random(u);
    const std::size_t count = in.count;
    Values wo = empty(count, 3), values = empty(bound.channels(), count), pdf = empty(1, count);
    float *to = wo.mutable_data(), *value = values.mutable_data(), *density = pdf.mutable_data();
    without_lock([&] {
        require_unit(in, "Bsdf.sample", "wi");
        require_all(u.data(), 3 * count, "Bsdf.sample", "u", allowed_random);
        bound.own.with_bsdf([&](const auto& bsdf) {
            for (std::size_t i = 0; i < count; ++i) {
                const auto [u1, u2, u3] = random.at(i);
                auto drawn = bsdf.sample(in.at(i), u1, u2, u3);
                if (!(drawn.pdf > 0)) drawn = {};
                const float components[] = {drawn.wo.x, drawn.wo.y, drawn.wo.z};
                std::copy_n(components, 3, to + 3 * i);
                put(drawn.value, value + i, count);
                density[i] = drawn.pdf;
            }
        });
    });
    return py::make_tuple(wo, values, pdf);
}

Values pdf(const Bound& bound, const Floats& wi, const Floats& wo) {
    const Vectors in(wi), out(wo);
    Values densities = empty(1, in.count);
    float* const density = densities.mutable_data();
    without_lock([&] {
        require_unit(in, "Bsdf.pdf", "wi");
        require_unit(out, "Bsdf.pdf", "wo", true);
        bound.own.with_bsdf([&](const auto& bsdf) {
            for (std::size_t i = 0; i < in.count; ++i) density[i] = bsdf.pdf(in.at(i), out.at(i));
        });
    });
    return densities;
}

/// Shares reflected and transmitted.
py::tuple albedo(const Bound& bound, const Floats& cosines) {
    const std::size_t count = element_count(cosines);
    Values reflected = empty(bound.channels(), count), transmitted = empty(bound.channels(), count);
    const float* const mu = cosines.data();
    float *up = reflected.mutable_data(), *down = transmitted.mutable_data();
    without_lock([&] {
        require_all(mu, count, "Bsdf.albedo", "mu_in", allowed_cosine);
        bound.own.with_bsdf([&](const auto& bsdf) {
            for (std::size_t i = 0; i < count; ++i) {
                const auto shares = bsdf.albedo(mu[i]);
                put(shares.reflected, up + i, count);
                put(shares.transmitted, down + i, count);
            }
        });
    });
    return py::make_tuple(reflected, transmitted);
}

}  // namespace

void add_slice(py::module_& module) {
    py::class_<Bound>(module, "Bound")
        .def("scattered", scattered)
        .def("eval", eval)
        .def("behind", behind)
        .def("sample", sample)
        .def("pdf", pdf)
        .def("albedo", albedo)
        .def("bytes",
             [](const Bound& bound) {
                 return bound.own.with_slice([](const auto& slice) { return slice.bytes(); });
             })
        .def("clamped", [](const Bound& bound) {
            return bound.own.with_slice([](const auto& slice) { return slice.clamped(); });
        });
    module.def("bind_table", bind_table);
    module.def("bind_single", bind_single);
}

}  // namespace stratus::python
