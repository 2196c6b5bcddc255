// Bound layers: R, T and BSDF values of one layer or three colours, and samples of its directions.
#include <stratus/base/constants.h>
#include <stratus/bsdf/bsdf.h>
#include <stratus/bsdf/slice.h>
#include <stratus/io/table_file.h>

#include <algorithm>
#include <cmath>
#include <variant>

#include "module.h"

namespace stratus::python {
namespace {

using Values = py::array_t<float>;

/// Directions that a narrowed table knows; all of any other.
struct KnownDirections {
    bool all = true;
    AxisView mu_in{}, mu_out{}, azimuth{};
};

class Bound {
  public:
    template <class Of>
    Bound(Of own, const KnownDirections& known) : known(known), own_(std::move(own)) {}

    std::size_t channels() const { return own_.index() % 2 == 0 ? 1 : 3; }

    template <class Use>
    auto with_slice(const Use& use) const {
        switch (own_.index()) {
            case 0: return use(std::get<0>(own_));
            case 1: return use(std::get<1>(own_));
            case 2: return use(std::get<2>(own_).slice());
            default: return use(std::get<3>(own_).slice());
        }
    }

    /// Range    of one that can be sampled.
    template <class Use>
    auto with_bsdf(const Use& use) const {
        return own_.index() == 2 ? use(std::get<2>(own_)) : use(std::get<3>(own_));
    }

    const KnownDirections known;

  private:
    std::variant<Slice, RgbSlice, Bsdf, RgbBsdf> own_;
};

// ---- binding ------------------------------------------------------------------------------------

template <int channels>
Medium<channels> make_medium(const std::vector<double>& optical_depth,
                             const std::vector<double>& albedo) {
    Medium<channels> medium;
    std::copy_n(optical_depth.begin(), channels, medium.optical_depth);
    std::copy_n(albedo.begin(), channels, medium.albedo);
    return medium;
}

/// `make(medium)`, of one or three channels, which can be sampled if asked.
template <class Make>
std::shared_ptr<Bound> bound(const std::vector<double>& optical_depth,
                             const std::vector<double>& albedo, bool sampled,
                             const KnownDirections& known, const Make& make) {
    const auto as_asked = [&](auto slice) {
        using Of = std::conditional_t<std::is_same_v<decltype(slice), Slice>, Bsdf, RgbBsdf>;
        return sampled ? std::make_shared<Bound>(Of(std::move(slice)), known)
                       : std::make_shared<Bound>(std::move(slice), known);
    };
    const py::gil_scoped_release release;
    return albedo.size() == 1 ? as_asked(make(make_medium<1>(optical_depth, albedo)))
                              : as_asked(make(make_medium<3>(optical_depth, albedo)));
}

Effects to_effects(const py::dict& asked) {
    Effects effects;
    const auto flag = [&](const char* name, bool& value) { value = asked[name].cast<bool>(); };
    flag("single", effects.single);
    flag("multiple", effects.multiple);
    flag("reflection", effects.reflection);
    flag("transmission", effects.transmission);
    flag("background", effects.background);
    effects.density = asked["density"].cast<double>();
    effects.opposition =
        make_opposition(asked["law"].cast<std::string>(), asked["width"].cast<double>(),
                        asked["amplitude"].cast<double>());
    return effects;
}

std::shared_ptr<Bound> bind_table(const AnyTable& table, const std::vector<double>& optical_depth,
                                  const std::vector<double>& albedo,
                                  const std::vector<double>& member, bool clamp, bool sampled,
                                  const py::dict& asked) {
    const Effects effects = to_effects(asked);
    const TableView all = table.view();
    const TableView view = all.at(FamilyPoint(member));
    const KnownDirections known{view.has_all_directions(), view.mu_in, view.mu_out, view.azimuth};
    const OutsideTable outside = clamp ? OutsideTable::clamp : OutsideTable::refuse;
    return bound(optical_depth, albedo, sampled, known,
                 [&]<int channels>(const Medium<channels>& medium) {
                     return SliceOf<channels>(view, medium, effects, outside);
                 });
}

std::shared_ptr<Bound> bind_single(const PhaseFunction& phase_function,
                                   const std::vector<double>& optical_depth,
                                   const std::vector<double>& albedo, bool sampled,
                                   const py::dict& asked) {
    const Effects effects = to_effects(asked);
    return bound(optical_depth, albedo, sampled, {},
                 [&]<int channels>(const Medium<channels>& medium) {
                     return SliceOf<channels>(phase_function, medium, effects);
                 });
}

// ---- lookups ------------------------------------------------------------------------------------

Values empty(std::size_t rows, std::size_t count) {
    return Values({static_cast<py::ssize_t>(rows), static_cast<py::ssize_t>(count)});
}

void put(float value, float* at, std::size_t) { *at = value; }

void put(const Rgb& value, float* at, std::size_t count) {
    at[0] = value.r;
    at[count] = value.g;
    at[2 * count] = value.b;
}

Vector vector_at(const float* vectors, std::size_t i) {
    return {vectors[3 * i], vectors[3 * i + 1], vectors[3 * i + 2]};
}

void require_unit(const float* vectors, std::size_t count, const char* function,
                  const char* argument) {
    constexpr float margin = 1e-3f;
    for (std::size_t i = 0; i < count; ++i) {
        const auto [x, y, z] = vector_at(vectors, i);
        const float squared = x * x + y * y + z * z;
        if (!(std::abs(squared - 1) <= margin))
            require(false, function, argument, "of length 1", std::sqrt(squared));
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
    require(known.azimuth.count == 1 && known.azimuth.lowest == 0
                ? true
                : is_within(known.azimuth, folded),
            function, "azimuth", "one that the table knows", azimuth);
}

void require_known(const KnownDirections& known, const char* function, const Vector& wi,
                   const Vector& wo) {
    const double azimuth = std::atan2(double{wo.y}, double{wo.x}) -
                           std::atan2(-double{wi.y}, -double{wi.x});  // 0 is the forward side
    require_known(known, function, std::abs(double{wi.z}), std::abs(double{wo.z}), azimuth);
}

Values scattered(const Bound& bound, bool transmitted, const Floats& mu_in, const Floats& mu_out,
                 const Floats& azimuth) {
    const std::size_t count = element_count(mu_in);
    Values values = empty(bound.channels(), count);
    const float *in = mu_in.data(), *out = mu_out.data(), *angle = azimuth.data();
    float* const value = values.mutable_data();
    const py::gil_scoped_release release;
    const char* const function = transmitted ? "Slice.transmission" : "Slice.reflection";
    require_all(in, count, function, "mu_in", allowed_cosine);
    require_all(out, count, function, "mu_out", allowed_cosine);
    require_all(angle, count, function, "azimuth", allowed_angle);
    if (!bound.known.all)
        for (std::size_t i = 0; i < count; ++i)
            require_known(bound.known, function, double{in[i]}, double{out[i]}, double{angle[i]});
    bound.with_slice([&](const auto& slice) {
        if (transmitted)
            slice.transmission(count, in, out, angle, value);
        else
            slice.reflection(count, in, out, angle, value);
    });
    return values;
}

/// `wi`, `wo`: (count, 3).
Values eval(const Bound& bound, const Floats& wi, const Floats& wo) {
    const std::size_t count = element_count(wi) / 3, channels = bound.channels();
    Values values = empty(channels, count);
    const float *in = wi.data(), *out = wo.data();
    float* const value = values.mutable_data();
    const py::gil_scoped_release release;
    require_unit(in, count, "Slice.eval", "wi");
    require_unit(out, count, "Slice.eval", "wo");
    if (!bound.known.all)
        for (std::size_t i = 0; i < count; ++i)
            require_known(bound.known, "Slice.eval", vector_at(in, i), vector_at(out, i));
    constexpr std::size_t piece = 512;
    float from[3][piece], to[3][piece], found[3 * piece];
    for (std::size_t first = 0; first < count; first += piece) {
        const std::size_t here = std::min(piece, count - first);
        for (std::size_t i = 0; i < here; ++i)
            for (std::size_t axis = 0; axis < 3; ++axis) {
                from[axis][i] = in[3 * (first + i) + axis];
                to[axis][i] = out[3 * (first + i) + axis];
            }
        const float* const wis[] = {from[0], from[1], from[2]};
        const float* const wos[] = {to[0], to[1], to[2]};
        bound.with_slice([&](const auto& slice) { slice.eval(here, wis, wos, found); });
        for (std::size_t c = 0; c < channels; ++c)
            std::copy_n(found + c * here, here, value + c * count + first);
    }
    return values;
}

/// direct, background or source_behind at cosines.
Values behind(const Bound& bound, const std::string& what, const Floats& cosines) {
    const std::size_t count = element_count(cosines);
    Values values = empty(bound.channels(), count);
    const float* const mu = cosines.data();
    float* const value = values.mutable_data();
    const py::gil_scoped_release release;
    require_all(mu, count, ("Slice." + what).c_str(), "mu", allowed_cosine);
    bound.with_slice([&](const auto& slice) {
        for (std::size_t i = 0; i < count; ++i)
            put(what == "direct"       ? slice.direct(mu[i])
                : what == "background" ? slice.background(mu[i])
                                       : slice.source_behind(mu[i]),
                value + i, count);
    });
    return values;
}

// ---- sampling -----------------------------------------------------------------------------------

/// wo, value and pdf of directions drawn by `u`, three numbers for each of `wi`: all (count, 3).
py::tuple sample(const Bound& bound, const Floats& wi, const Floats& u) {
    const std::size_t count = element_count(wi) / 3;
    Values wo = empty(count, 3), values = empty(bound.channels(), count), pdf = empty(1, count);
    const float *in = wi.data(), *random = u.data();
    float *to = wo.mutable_data(), *value = values.mutable_data(), *density = pdf.mutable_data();
    {
        const py::gil_scoped_release release;
        require_unit(in, count, "Bsdf.sample", "wi");
        require_all(random, 3 * count, "Bsdf.sample", "u", allowed_random);
        bound.with_bsdf([&](const auto& bsdf) {
            for (std::size_t i = 0; i < count; ++i) {
                const auto [u1, u2, u3] = vector_at(random, i);
                auto drawn = bsdf.sample(vector_at(in, i), u1, u2, u3);
                if (!(drawn.pdf > 0)) drawn = {};
                const float components[] = {drawn.wo.x, drawn.wo.y, drawn.wo.z};
                std::copy_n(components, 3, to + 3 * i);
                density[i] = drawn.pdf;
                put(drawn.value, value + i, count);
            }
        });
    }
    return py::make_tuple(wo, values, pdf);
}

Values pdf(const Bound& bound, const Floats& wi, const Floats& wo) {
    const std::size_t count = element_count(wi) / 3;
    Values densities = empty(1, count);
    const float *in = wi.data(), *out = wo.data();
    float* const density = densities.mutable_data();
    const py::gil_scoped_release release;
    require_unit(in, count, "Bsdf.pdf", "wi");
    require_unit(out, count, "Bsdf.pdf", "wo");
    bound.with_bsdf([&](const auto& bsdf) {
        for (std::size_t i = 0; i < count; ++i)
            density[i] = bsdf.pdf(vector_at(in, i), vector_at(out, i));
    });
    return densities;
}

/// Shares reflected and transmitted.
py::tuple albedo(const Bound& bound, const Floats& cosines) {
    const std::size_t count = element_count(cosines);
    Values reflected = empty(bound.channels(), count), transmitted = empty(bound.channels(), count);
    const float* const mu = cosines.data();
    float *up = reflected.mutable_data(), *down = transmitted.mutable_data();
    {
        const py::gil_scoped_release release;
        require_all(mu, count, "Bsdf.albedo", "mu_in", allowed_cosine);
        bound.with_bsdf([&](const auto& bsdf) {
            for (std::size_t i = 0; i < count; ++i) {
                const auto shares = bsdf.albedo(mu[i]);
                put(shares.reflected, up + i, count);
                put(shares.transmitted, down + i, count);
            }
        });
    }
    return py::make_tuple(reflected, transmitted);
}

}  // namespace

void add_slice(py::module_& module) {
    py::class_<Bound, std::shared_ptr<Bound>>(module, "Bound")
        .def("scattered", scattered)
        .def("eval", eval)
        .def("behind", behind)
        .def("sample", sample)
        .def("pdf", pdf)
        .def("albedo", albedo)
        .def("bytes",
             [](const Bound& bound) {
                 return bound.with_slice([](const auto& slice) { return slice.bytes(); });
             })
        .def("clamped", [](const Bound& bound) {
            return bound.with_slice([](const auto& slice) { return slice.clamped(); });
        });
    module.def("bind_table", bind_table);
    module.def("bind_single", bind_single);
}

}  // namespace stratus::python
