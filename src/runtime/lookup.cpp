#include <stratus/runtime/lookup.h>

#include <stratus/runtime/angle.h>
#include <stratus/runtime/diffusion.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>

namespace stratus {
namespace {

constexpr int window = 4;  // samples of a cubic

/// Where less than this of the law of diffusion is left at the deepest sample, that sample is the
/// limit itself.
constexpr double least_deficit = 1e-5;

/// One (albedo, optical_depth) of a side: where its directions start, its share of the answer, its
/// depth.
struct Layer {
    const float* samples;
    float share;
    int depth;
};

/// The layers that a lookup adds up; no more than 4 albedos by 4 depths.
struct Layers {
    Layer layer[window * window];
    int count = 0;
};

/// What is asked of the multiply scattered part.
struct Query {
    Stencil albedo_stencil;
    double albedo;  // clamped to the axis; 1 where samples are not divided by anything
    double optical_depth;
    double diffusion_exponent;
};

/// Windows of the three directions, and where their samples lie.
struct Directions {
    Stencil in, out, azimuth;
    int in_sample[window], out_sample[window];
    int azimuth_count;
};

int used(const AxisView& axis) noexcept { return std::min(axis.count, window); }

/// Samples of a window; weights beyond a short axis are 0 and point at its last sample.
void set_samples(const AxisView& axis, const Stencil& stencil, int (&sample)[window]) noexcept {
    for (int i = 0; i < window; ++i) sample[i] = std::min(stencil.first + i, axis.count - 1);
}

Directions directions_of(const TableView& table, const Geometry& geometry) noexcept {
    double azimuth = geometry.azimuth;
    if (!(azimuth >= 0 && azimuth <= pi)) azimuth = std::abs(std::remainder(azimuth, 2 * pi));
    Directions at;
    at.in = table.mu_in.stencil(geometry.mu_in);
    at.out = table.mu_out.stencil(geometry.mu_out);
    at.azimuth = table.azimuth.stencil(azimuth);
    at.azimuth_count = used(table.azimuth);
    set_samples(table.mu_in, at.in, at.in_sample);
    set_samples(table.mu_out, at.out, at.out_sample);
    return at;
}

/// `width` neighbouring azimuths, added and scaled side by side.
template <int width>
struct Row {
    float value[width];

    float operator[](int k) const noexcept { return value[k]; }

    Row& operator+=(const Row& other) noexcept {
        for (int k = 0; k < width; ++k) value[k] += other.value[k];
        return *this;
    }

    friend Row operator+(Row left, const Row& right) noexcept { return left += right; }

    friend Row operator*(float factor, Row row) noexcept {
        for (float& value : row.value) value *= factor;
        return row;
    }
};

template <int width>
struct RowOf {
    using type = Row<width>;
};

#if defined(__GNUC__)
// The same four floats as the compiler's own vector: with optimisation on, g++ 12 leaves the struct
// scalar and takes three times as long.
template <>
struct RowOf<4> {
    using type = float __attribute__((vector_size(4 * sizeof(float))));
};
#endif

/// Sum over layers and directions; `width` is how many azimuths a window holds.
template <int width>
double summed(const TableView& table, const Layers& layers, const Directions& at) noexcept {
    using Azimuths = typename RowOf<width>::type;
    const auto row = [](const float* samples) {
        Azimuths values;
        std::memcpy(&values, samples, sizeof values);
        return values;
    };
    const std::ptrdiff_t in_count = table.mu_in.count, out_count = table.mu_out.count;
    const std::ptrdiff_t out_stride = table.azimuth.count, in_stride = out_stride * out_count;
    std::ptrdiff_t in_offset[window], out_offset[window];
    for (int i = 0; i < window; ++i) {
        in_offset[i] = at.in_sample[i] * in_stride + at.azimuth.first;
        out_offset[i] = at.out_sample[i] * out_stride;
    }
    Azimuths sum{};
    float in[window], out[window];
    for (int n = 0; n < layers.count; ++n) {
        const Layer& layer = layers.layer[n];
        if (n == 0 || layer.depth != layers.layer[n - 1].depth) {
            const float* const in_weight = table.mu_in_weight + layer.depth * in_count;
            const float* const out_weight = table.mu_out_weight + layer.depth * out_count;
            for (int i = 0; i < window; ++i) {
                in[i] = at.in.weight[i] * in_weight[at.in_sample[i]];
                out[i] = at.out.weight[i] * out_weight[at.out_sample[i]];
            }
        }
        for (int i = 0; i < window; ++i) {
            const float share = layer.share * in[i];
            const float* const rows = layer.samples + in_offset[i];
            const auto out_row = [&](int j) { return row(rows + out_offset[j]); };
            sum += share * ((out[0] * out_row(0) + out[1] * out_row(1)) +
                            (out[2] * out_row(2) + out[3] * out_row(3)));
        }
    }
    double total = 0;
    for (int k = 0; k < width; ++k) total += double{at.azimuth.weight[k]} * double{sum[k]};
    return total;
}

double summed(const TableView& table, const Layers& layers, const Directions& at) noexcept {
    switch (at.azimuth_count) {
        case 1: return summed<1>(table, layers, at);
        case 2: return summed<2>(table, layers, at);
        case 3: return summed<3>(table, layers, at);
        default: return summed<4>(table, layers, at);
    }
}

/// One side of a table, and the layers of it that a query needs.
class Side {
  public:
    Side(const TableView& table, const float* samples, const float* weight) noexcept
        : table_(table),
          samples_(samples),
          weight_(weight),
          depths_(table.optical_depth.size()),
          layer_size_(std::ptrdiff_t{table.mu_in.count} * table.mu_out.count *
                      table.azimuth.count) {}

    /// The samples of one depth around an albedo. One too deep to be scaled back up hands its share
    /// to the neighbour of higher albedo, which decays more slowly; false comes back when there is
    /// none to take it.
    bool add_depth(const Query& query, int depth, double share) noexcept {
        double handed_on = 0;
        for (int l = 0; l < used(table_.albedo); ++l) {
            const double part = share * double{query.albedo_stencil.weight[l]} + handed_on;
            handed_on = add(query.albedo_stencil.first + l, depth, part) ? 0 : part;
        }
        return handed_on == 0;
    }

    /// Cubic along optical depth within the finite samples. A depth that no sample can speak for
    /// hands its share to the one above it.
    void add_depths(const Query& query, double scale) noexcept {
        const Stencil depth = table_.optical_depth.stencil(query.optical_depth);
        double handed_on = 0;
        for (int t = used(table_.optical_depth) - 1; t >= 0; --t) {
            const double share = scale * double{depth.weight[t]} + handed_on;
            handed_on = add_depth(query, depth.first + t, share) ? 0 : share;
        }
    }

    /// Between the deepest finite sample and the one at infinity the distance from the limit dies
    /// away by the law of diffusion; the scale of the sample at infinity is 1. Albedos whose
    /// deficit is spent hand their share of it on, as above.
    void add_between_last_and_infinity(const Query& query) noexcept {
        const double length = table_.extrapolation_length, highest = table_.optical_depth.highest;
        const bool over_below = table_.lies_on_something();
        const double deficit =
            reflection_deficit(query.optical_depth, query.diffusion_exponent, length);
        const int last = table_.optical_depth.count - 1;
        double handed_on = 0;
        for (int l = 0; l < used(table_.albedo); ++l) {
            const int albedo = query.albedo_stencil.first + l;
            const double exponent = table_.diffusion_exponent[albedo];
            const double deepest = last < 0 ? 0 : reflection_deficit(highest, exponent, length);
            const double weight = double{query.albedo_stencil.weight[l]};
            const bool spent = deepest < least_deficit;
            const double share = spent ? 0 : (weight + handed_on) * deficit / deepest;
            handed_on = spent ? weight + handed_on : 0;
            add(albedo, last + 1, query.albedo * (weight - share));
            if (!spent)
                add(albedo, last,
                    query.albedo * share *
                        (over_below ? 1 : reflection_scale(highest, exponent, length)));
        }
    }

    /// The layers' sum over directions, times what the samples were divided by along both of them.
    double sum(const Query& query, const Geometry& geometry) const noexcept {
        const double directions = summed(table_, layers_, directions_of(table_, geometry));
        const auto intercepted = [&](double depth, const AxisView& axis, double mu) {
            return intercepted_share(depth, std::clamp(mu, axis.lowest, axis.highest));
        };
        if (!table_.lies_on_something())
            return intercepted(query.optical_depth, table_.mu_in, geometry.mu_in) *
                   intercepted(query.optical_depth, table_.mu_out, geometry.mu_out) * directions;
        const AxisView& depth = table_.optical_depth;
        const bool fades = table_.below->kind == Below::Kind::surface && depth.count > 0 &&
                           query.optical_depth < depth.lowest;
        if (!fades) return directions;
        // A surface alone scatters once; what a thin layer adds is what it takes out of the beams.
        const auto taken_out = [&](double at) {
            return intercepted(at, table_.mu_in, geometry.mu_in) +
                   intercepted(at, table_.mu_out, geometry.mu_out);
        };
        return taken_out(query.optical_depth) / taken_out(depth.lowest) * directions;
    }

  private:
    /// False when the sample is too small to be scaled back up.
    bool add(int albedo, int depth, double share) noexcept {
        const std::ptrdiff_t at = std::ptrdiff_t{albedo} * depths_ + depth;
        if (weight_[at] == 0) return false;
        if (share != 0)
            layers_.layer[layers_.count++] = {samples_ + at * layer_size_,
                                              static_cast<float>(share * double{weight_[at]}),
                                              depth};
        return true;
    }

    const TableView& table_;
    const float* samples_;
    const float* weight_;
    int depths_;
    std::ptrdiff_t layer_size_;
    Layers layers_;
};

Query query_of(const TableView& table, double albedo, double optical_depth) noexcept {
    Query query{table.albedo.stencil(albedo),
                std::clamp(albedo, table.albedo.lowest, table.albedo.highest), optical_depth, 0};
    for (int l = 0; l < used(table.albedo); ++l)
        query.diffusion_exponent += double{query.albedo_stencil.weight[l]} *
                                    table.diffusion_exponent[query.albedo_stencil.first + l];
    query.diffusion_exponent = std::max(0.0, query.diffusion_exponent);
    const AxisView& depth = table.optical_depth;
    if (!depth.ends_at_infinity) query.optical_depth = std::min(optical_depth, depth.highest);
    if (table.lies_on_something()) query.albedo = 1;
    return query;
}

double multiple_reflection(const TableView& table, double albedo, double optical_depth,
                           const Geometry& geometry) noexcept {
    const Query query = query_of(table, albedo, optical_depth);
    const AxisView& depth = table.optical_depth;
    Side side(table, table.reflection_multiple, table.reflection_weight);
    if (depth.ends_at_infinity && (depth.count == 0 || query.optical_depth > depth.highest))
        side.add_between_last_and_infinity(query);
    else if (table.lies_on_something())
        side.add_depths(query, 1);
    else
        side.add_depths(
            query, query.albedo * reflection_scale(query.optical_depth, query.diffusion_exponent,
                                                   table.extrapolation_length));
    return side.sum(query, geometry);
}

double multiple_transmission(const TableView& table, double albedo, double optical_depth,
                             const Geometry& geometry) noexcept {
    const AxisView& depth = table.optical_depth;
    if (depth.count == 0) return 0;  // nothing passes a layer without end
    const Query query = query_of(table, albedo, optical_depth);
    const double scale =
        query.albedo * transmission_scale(query.optical_depth, query.diffusion_exponent,
                                          table.extrapolation_length);
    Side side(table, table.transmission_multiple, table.transmission_weight);
    if (query.optical_depth > depth.highest)
        side.add_depth(query, depth.count - 1, scale);
    else
        side.add_depths(query, scale);
    return side.sum(query, geometry);
}

}  // namespace

Scattered reflection(const TableView& table, double albedo, double optical_depth,
                     const Geometry& geometry) noexcept {
    const double phase = (*table.phase_function)(cos_scattering_angle_reflected(geometry));
    Scattered scattered{};
    scattered.single =
        single_reflection(phase, albedo, optical_depth, geometry.mu_in, geometry.mu_out);
    if (table.lies_on_something())
        scattered.single += single_reflection_below(*table.below, optical_depth, geometry);
    if (table.has_reflection())
        scattered.multiple = multiple_reflection(table, albedo, optical_depth, geometry);
    return scattered;
}

Scattered transmission(const TableView& table, double albedo, double optical_depth,
                       const Geometry& geometry) noexcept {
    Scattered scattered{};
    if (table.lies_on_something()) return scattered;
    const double phase = (*table.phase_function)(cos_scattering_angle_transmitted(geometry));
    scattered.single =
        single_transmission(phase, albedo, optical_depth, geometry.mu_in, geometry.mu_out);
    if (table.has_transmission())
        scattered.multiple = multiple_transmission(table, albedo, optical_depth, geometry);
    return scattered;
}

}  // namespace stratus
