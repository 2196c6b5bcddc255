#include <stratus/runtime/slice.h>

#include <stratus/runtime/angle.h>
#include <stratus/runtime/argument.h>
#include <stratus/runtime/single_scattering.h>

#include "kept_tolerance.h"
#include "kernels/kernels.h"
#include "layers.h"
#include "mu_places.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace stratus {
namespace {

constexpr const char* caller = "bind";
/// Share of the tolerance that straight lines along each of the three axes may use up.
constexpr double share_of_tolerance = 0.2;

// Intervals along an axis while its need is found out, and of the slice.
constexpr int probed = 32, fewest = 16, max_along_mu = 176, max_along_azimuth = 128;

std::size_t size(int n) { return static_cast<std::size_t>(n); }

/// Values over three axes, the last contiguous.
struct Sheet {
    int count[3];
    std::vector<float> value;

    Sheet(int a, int b, int c) : count{a, b, c}, value(size(a) * size(b) * size(c)) {}

    float* row(int i, int j) {
        return &value[(size(i) * size(count[1]) + size(j)) * size(count[2])];
    }
    const float* row(int i, int j) const {
        return &value[(size(i) * size(count[1]) + size(j)) * size(count[2])];
    }
};

/// Samples of an axis and their weights, for each place of a finer one.
using Stencils = std::vector<Stencil>;

/// Cosines of a slice, from the table's largest to its smallest.
struct MuPlaces {
    double first, step;
    int intervals;

    MuPlaces(const AxisView& axis, int intervals_)
        : first(v_at(axis.highest)),
          step((v_at(axis.lowest) - first) / intervals_),
          intervals(intervals_) {}

    double mu(int i) const { return mu_at(first + step * i); }

    Stencils stencils(const AxisView& axis) const {
        Stencils all;
        for (int i = 0; i <= intervals; ++i) all.push_back(axis.stencil(mu(i)));
        return all;
    }
};

double azimuth_at(int k, int intervals) {
    return 2 * std::asin(std::min(1.0, static_cast<double>(k) / intervals));
}

Stencils azimuth_stencils(const AxisView& axis, int intervals) {
    Stencils all;
    for (int k = 0; k <= intervals; ++k) all.push_back(axis.stencil(azimuth_at(k, intervals)));
    return all;
}

/// The sum over the layers that speak for a medium, as samples are stored: over (mu_in, mu_out,
/// azimuth), to be multiplied by the shares intercepted.
Sheet summed(const TableView& table, const Layers& layers) {
    Sheet sum(table.mu_in.count, table.mu_out.count, table.azimuth.count);
    const int columns = table.azimuth.count;
    std::vector<float> widened(layers.samples.halves ? sum.value.size() : 0);
    for (int n = 0; n < layers.count; ++n) {
        const Layer& layer = layers.layer[n];
        const float* const in = table.mu_in_weight + layer.depth * table.mu_in.count;
        const float* const out = table.mu_out_weight + layer.depth * table.mu_out.count;
        layers.samples.copy(layer.first, static_cast<std::ptrdiff_t>(widened.size()),
                            widened.data());
        const float* from = widened.empty() ? layers.samples.floats + layer.first : widened.data();
        float* to = sum.value.data();
        for (int i = 0; i < table.mu_in.count; ++i)
            for (int j = 0; j < table.mu_out.count; ++j) {
                const float share = layer.share * in[i] * out[j];
                for (int k = 0; k < columns; ++k) *to++ += share * *from++;
            }
    }
    return sum;
}

/// Cubic along one axis of a sheet.
Sheet refined_azimuth(const Sheet& sheet, const Stencils& stencils) {
    Sheet finer(sheet.count[0], sheet.count[1], static_cast<int>(stencils.size()));
    for (int i = 0; i < sheet.count[0]; ++i)
        for (int j = 0; j < sheet.count[1]; ++j) {
            const float* const from = sheet.row(i, j);
            float* const to = finer.row(i, j);
            for (std::size_t k = 0; k < stencils.size(); ++k) {
                float value = 0;
                for (int s = 0; s < std::min(window, sheet.count[2]); ++s)
                    value += stencils[k].weight[s] * from[stencils[k].first + s];
                to[k] = value;
            }
        }
    return finer;
}

/// A row of values from up to four others.
void add_rows(const Stencil& stencil, int available, int columns,
              const float* const (&from)[window], float* to) {
    if (available < window) {
        for (int s = 0; s < available; ++s)
            for (int k = 0; k < columns; ++k) to[k] += stencil.weight[s] * from[s][k];
        return;
    }
    const float a = stencil.weight[0], b = stencil.weight[1], c = stencil.weight[2],
                d = stencil.weight[3];
    for (int k = 0; k < columns; ++k)
        to[k] = a * from[0][k] + b * from[1][k] + c * from[2][k] + d * from[3][k];
}

/// Rows of a sheet around one place along its first axis: the sum over them, `columns` numbers.
void add_rows_of(const Sheet& sheet, const Stencil& stencil, int columns, float* to) {
    const int available = std::min(window, sheet.count[0]);
    const float* from[window] = {};
    for (int s = 0; s < available; ++s) from[s] = sheet.row(stencil.first + s, 0);
    add_rows(stencil, available, columns, from, to);
}

Sheet refined_in(const Sheet& sheet, const Stencils& stencils) {
    Sheet finer(static_cast<int>(stencils.size()), sheet.count[1], sheet.count[2]);
    for (int i = 0; i < finer.count[0]; ++i)
        add_rows_of(sheet, stencils[size(i)], sheet.count[1] * sheet.count[2], finer.row(i, 0));
    return finer;
}

/// Intervals with which straight lines are exact enough, from what `probed` of them are off by.
int intervals_for(double error, double allowed, int most) {
    const double needed = std::ceil(probed * std::sqrt(error / allowed));
    return static_cast<int>(std::clamp(needed, double{fewest}, static_cast<double>(most)));
}

/// Errors relative to the totals where they were met, at places spread evenly over the axes.
class Errors {
  public:
    void add(double error, double total) { errors_.push_back({std::abs(error), total}); }

    /// What 99.9 % of them stay below; totals below `least` count as that.
    double common(double least) const {
        constexpr int bins = 64, bins_an_octave = 2;  // downwards from `highest`
        constexpr double highest = 16, rare = 1e-3;
        std::size_t count[bins] = {};
        for (const Error& at : errors_) {
            const double ratio = at.error / std::max(at.total, least);
            if (!(ratio > 0)) continue;
            const double down = bins_an_octave * std::log2(highest / ratio);
            ++count[static_cast<int>(std::clamp(down, 0.0, bins - 1.0))];
        }
        const double most = rare * static_cast<double>(errors_.size());
        int bin = 0;
        for (std::size_t above = count[0]; static_cast<double>(above) <= most && bin + 1 < bins;
             above += count[bin])
            ++bin;
        return highest * std::exp2(-static_cast<double>(bin) / bins_an_octave);
    }

  private:
    struct Error {
        double error, total;
    };
    std::vector<Error> errors_;
};

/// Orders n >= 2 of one channel while they are refined.
template <class Single>
class Refinement {
  public:
    /// `single` gives single scattering at (mu_in, mu_out, azimuth).
    Refinement(const TableView& table, const Layers& layers, const Single& single)
        : table_(table), layers_(layers), single_(single), sheet_(summed(table, layers)) {
        if (!layers_.fades) return;
        for (int i = 0; i < sheet_.count[0]; ++i)
            for (int j = 0; j < sheet_.count[1]; ++j)
                for (int k = 0; k < sheet_.count[2]; ++k)
                    sheet_.row(i, j)[k] *= static_cast<float>(directional_factor(
                        table_, layers_, table_.mu_in.value(i), table_.mu_out.value(j)));
    }

    /// What straight lines between `probed` + 1 samples are off by along mu and along azimuth,
    /// relative to R or T: an eighth of the second differences.
    std::array<double, 2> errors_of_straight_lines() const {
        const MuPlaces places(table_.mu_in, probed);
        const int cosines = sheet_.count[1], columns = sheet_.count[2];
        const Sheet along_mu = refined_in(sheet_, places.stencils(table_.mu_in));
        const int azimuth_step = std::max(1, (columns - 1) / 4);  // a few speak for all
        Errors of_mu, of_azimuth;
        double largest = 0;
        for (int i = 1; i < probed; ++i)
            for (int j = 0; j < cosines; ++j) {
                const double in = places.mu(i), out = table_.mu_out.value(j);
                const double factor = divided_by(in, out);
                for (int k = 0; k < columns; k += azimuth_step) {
                    const auto at = [&](int row) { return double{along_mu.row(row, j)[k]}; };
                    const double total = at(i) * factor + single_(in, out, table_.azimuth.value(k));
                    of_mu.add((at(i - 1) - 2 * at(i) + at(i + 1)) / 8 * factor, total);
                    if (in >= 0.1 && out >= 0.1) largest = std::max(largest, total);
                }
            }
        if (columns > 1) {
            const Sheet along_azimuth =
                refined_azimuth(sheet_, azimuth_stencils(table_.azimuth, probed));
            constexpr int cosine_step = 3;
            for (int i = 0; i < sheet_.count[0]; i += cosine_step)
                for (int j = 0; j <= i; j += cosine_step) {
                    const double in = table_.mu_in.value(i), out = table_.mu_out.value(j);
                    const double factor = divided_by(in, out);
                    const float* const row = along_azimuth.row(i, j);
                    for (int k = 1; k < probed; ++k) {
                        const double bend =
                            double{row[k - 1]} - 2 * double{row[k]} + double{row[k + 1]};
                        const double total =
                            double{row[k]} * factor + single_(in, out, azimuth_at(k, probed));
                        of_azimuth.add(bend / 8 * factor, total);
                    }
                }
        }
        return {of_mu.common(darkest_share * largest), of_azimuth.common(darkest_share * largest)};
    }

    /// All samples: row i over mu holds mu' = 0 .. i + 1 by azimuth, `stride` apart.
    void write(const MuPlaces& places, int azimuths, int stride, float* to) const {
        const Stencils cosines = places.stencils(table_.mu_in);
        const Sheet finer =
            azimuths > 1 ? refined_azimuth(sheet_, azimuth_stencils(table_.azimuth, azimuths - 1))
                         : sheet_;
        const int available = std::min(window, finer.count[1]);
        Sheet row(1, finer.count[1], azimuths), cell(1, 1, azimuths);
        for (int i = 0; i <= places.intervals; ++i) {
            std::fill(row.value.begin(), row.value.end(), 0.0f);
            add_rows_of(finer, cosines[size(i)], finer.count[1] * azimuths, row.row(0, 0));
            for (int j = 0; j <= i + 1; ++j) {  // the last row ends in one that is never reached
                const Stencil& stencil = cosines[size(std::min(j, places.intervals))];
                const float* from[window] = {};
                for (int s = 0; s < available; ++s) from[s] = row.row(0, stencil.first + s);
                float* const sums = stride == 1 ? to : cell.row(0, 0);
                std::fill(sums, sums + azimuths, 0.0f);
                add_rows(stencil, available, azimuths, from, sums);
                if (stride > 1)
                    for (int k = 0; k < azimuths; ++k) to[k * stride] = sums[k];
                to += size(azimuths) * size(stride);
            }
        }
    }

  private:
    double divided_by(double mu_in, double mu_out) const {
        return table_.has_lower_boundary() ? 1 : directional_factor(table_, layers_, mu_in, mu_out);
    }

    const TableView& table_;
    const Layers& layers_;
    Single single_;
    Sheet sheet_;
};

/// Refines the orders n >= 2 of a side; `single` gives single scattering of channel c at (c, mu_in,
/// mu_out, azimuth).
template <int channels, class Single>
std::vector<float> refined(const TableView& table, const Layers (&layers)[channels],
                           const Single& single, SliceSide<channels>& view) {
    const auto of_channel = [&](int c) {
        return Refinement(table, layers[c], [&single, c](double in, double out, double azimuth) {
            return single(c, in, out, azimuth);
        });
    };
    std::vector<decltype(of_channel(0))> refinements;
    double mu_error = 0, azimuth_error = 0;
    for (int c = 0; c < channels; ++c) {
        refinements.push_back(of_channel(c));
        const auto [along_mu, along_azimuth] = refinements.back().errors_of_straight_lines();
        mu_error = std::max(mu_error, along_mu);
        azimuth_error = std::max(azimuth_error, along_azimuth);
    }
    const double allowed = share_of_tolerance * kept_tolerance(table);
    const int azimuths =
        table.azimuth.count < 2 ? 1 : 1 + intervals_for(azimuth_error, allowed, max_along_azimuth);
    const MuPlaces places(
        table.mu_in, table.mu_in.count < 2 ? 1 : intervals_for(mu_error, allowed, max_along_mu));
    // Rows 0 to `intervals`, the last one column short.
    const std::size_t rows = size(places.intervals + 1);
    std::vector<float> samples(rows * (rows + 3) / 2 * size(azimuths) * channels + 1);
    for (std::size_t c = 0; c < refinements.size(); ++c)
        refinements[c].write(places, azimuths, channels, samples.data() + c);
    view.sample = samples.data();
    view.azimuths = azimuths;
    view.last_mu = places.intervals;
    view.mu_first = static_cast<float>(places.first);
    view.mu_step_inverse = places.step > 0 ? static_cast<float>(1 / places.step) : 0;
    return samples;
}

template <int channels>
const SideKernel<channels>& kernel_of(bool reflected, PhaseForm form, Orders orders) {
    const Kernels& all = kernels();
    if constexpr (channels == 1)
        return (reflected ? all.reflected : all.transmitted).of(form, orders);
    else
        return (reflected ? all.reflected_rgb : all.transmitted_rgb).of(form, orders);
}

template <int channels>
auto value_of(const float (&value)[channels], float factor) noexcept {
    if constexpr (channels == 1)
        return value[0] * factor;
    else
        return Rgb{value[0] * factor, value[1] * factor, value[2] * factor};
}

}  // namespace

template <int channels>
struct SliceOf<channels>::BoundSide {
    SliceSide<channels> view{};
    PhaseForm form = PhaseForm::none;
    Orders orders = Orders::none;
    SideKernel<channels> kernel{};  // null functions: nothing comes this way
    std::vector<float> sample;
    PhaseCurve phase;
};

template <int channels>
SliceOf<channels>::SliceOf(SliceOf&&) noexcept = default;
template <int channels>
SliceOf<channels>& SliceOf<channels>::operator=(SliceOf&&) noexcept = default;
template <int channels>
SliceOf<channels>::~SliceOf() = default;

template <int channels>
SliceOf<channels>::SliceOf(const PhaseFunction& phase_function, const PhaseCurve& curve,
                           const LowerBoundary* boundary, const Medium<channels>& medium,
                           const Effects& effects)
    : medium_(medium),
      reflection_(std::make_unique<BoundSide>()),
      transmission_(std::make_unique<BoundSide>()) {
    check_effects(effects);
    for (int c = 0; c < channels; ++c) {
        require(medium.optical_depth[c] >= 0, caller, "optical_depth", "in [0, inf]",
                medium.optical_depth[c]);
        require(medium.albedo[c] >= 0 && medium.albedo[c] <= 1, caller, "albedo", "in [0, 1]",
                medium.albedo[c]);
        medium_.optical_depth[c] =
            effective_optical_depth(medium.optical_depth[c], effects.density);
    }
    one_sided_ = boundary != nullptr && boundary->is_present();
    if (effects.single) forward_phase_ = static_cast<float>(phase_function(1));
    const auto set_medium = [&](SliceSide<channels>& view, double deepest) {
        for (int c = 0; c < channels; ++c) {
            view.optical_depth[c] = static_cast<float>(std::min(medium_.optical_depth[c], deepest));
            view.quarter_albedo[c] = static_cast<float>(medium_.albedo[c] / 4);
        }
        view.level = one_sided_ ? 1 : 0;
        view.slope = one_sided_ ? 0 : 1;
    };
    if (effects.reflection) {
        SliceSide<channels>& view = reflection_->view;
        set_medium(view, 1e30);
        if (effects.single) {
            const bool layer_below = one_sided_ && boundary->kind == LowerBoundary::Kind::layer;
            const bool plain = effects.opposition.law == Opposition::Law::none && !layer_below;
            reflection_->phase = plain ? curve
                                       : PhaseCurve::with_opposition_and_boundary(
                                             phase_function, effects.opposition, boundary);
            reflection_->form = reflection_->phase.form();
            for (int c = 0; c < channels; ++c) {
                view.surface_albedo[c] =
                    one_sided_ && !layer_below ? static_cast<float>(boundary->albedo) : 0;
                view.boundary_quarter_albedo[c] =
                    layer_below ? static_cast<float>(boundary->albedo / 4) : 0;
            }
        }
    }
    if (effects.transmission && !one_sided_) {
        set_medium(transmission_->view, 1e4);  // nothing passes a hundred
        if (effects.single) {
            transmission_->phase = curve;
            transmission_->form = curve.form();
        }
    }
    for (BoundSide* side : {reflection_.get(), transmission_.get()})
        side->view.phase = side->phase.view();
    set_kernels();
}

template <int channels>
SliceOf<channels>::SliceOf(const PhaseFunction& phase_function, const Medium<channels>& medium,
                           const Effects& effects)
    : SliceOf(phase_function, PhaseCurve(phase_function), nullptr, medium, effects) {}

template <int channels>
SliceOf<channels>::SliceOf(const TableView& table, const Medium<channels>& medium,
                           const Effects& effects)
    : SliceOf(table.mixed_phase_function(),
              table.has_mixture() ? PhaseCurve(table.mixed_phase_function()) : *table.phase_curve,
              table.lower_boundary, medium, effects) {
    require(table.mu_in.count == table.mu_out.count && table.mu_in.lowest == table.mu_out.lowest &&
                table.mu_in.highest == table.mu_out.highest,
            caller, "mu_out of the table", "the same axis as mu_in", "another");
    if (!effects.multiple) return;
    const Orders orders = table.azimuth.count > 1 ? Orders::with_azimuth : Orders::without_azimuth;
    const auto add_orders = [&](BoundSide& side, bool reflected) {
        Layers layers[channels];
        for (int c = 0; c < channels; ++c)
            layers[c] =
                reflected ? reflection_layers(table, medium_.albedo[c], medium_.optical_depth[c])
                          : transmission_layers(table, medium_.albedo[c], medium_.optical_depth[c]);
        const auto single = [&](int c, double mu_in, double mu_out, double azimuth) {
            if (side.kernel.at_angles == nullptr) return 0.0;
            float value[channels];
            side.kernel.at_angles(side.view, static_cast<float>(mu_in), static_cast<float>(mu_out),
                                  static_cast<float>(azimuth), value);
            return double{value[c]};
        };
        side.sample = refined(table, layers, single, side.view);
        side.orders = orders;
    };
    if (effects.reflection && table.has_reflection()) add_orders(*reflection_, true);
    if (effects.transmission && table.has_transmission()) add_orders(*transmission_, false);
    set_kernels();
}

template <int channels>
void SliceOf<channels>::set_kernels() {
    reflection_->kernel = kernel_of<channels>(true, reflection_->form, reflection_->orders);
    transmission_->kernel = kernel_of<channels>(false, transmission_->form, transmission_->orders);
}

template <int channels>
typename SliceOf<channels>::Value SliceOf<channels>::at(const BoundSide& side, float mu_in,
                                                        float mu_out,
                                                        float azimuth) const noexcept {
    float value[channels] = {};
    if (side.kernel.at_angles != nullptr)
        side.kernel.at_angles(side.view, mu_in, mu_out, azimuth, value);
    return value_of(value, 1);
}

template <int channels>
typename SliceOf<channels>::Value SliceOf<channels>::reflection(float mu_in, float mu_out,
                                                                float azimuth) const noexcept {
    return at(*reflection_, mu_in, mu_out, azimuth);
}

template <int channels>
typename SliceOf<channels>::Value SliceOf<channels>::transmission(float mu_in, float mu_out,
                                                                  float azimuth) const noexcept {
    return at(*transmission_, mu_in, mu_out, azimuth);
}

template <int channels>
typename SliceOf<channels>::Value SliceOf<channels>::eval(const Vector& wi,
                                                          const Vector& wo) const noexcept {
    const float sides = wi.z * wo.z;
    if (!(sides != 0) || (one_sided_ && !(wi.z > 0 && wo.z > 0))) return Value{};
    const BoundSide& side = *(sides > 0 ? reflection_ : transmission_);
    float value[channels] = {};
    if (side.kernel.at_angles != nullptr) side.kernel.at_vectors(side.view, wi, wo, value);
    return value_of(value, static_cast<float>(1 / pi));
}

namespace {

/// Blocks of `paths_at_once` lookups; the last may be shorter. use(first, count).
template <class Use>
void in_blocks(std::size_t count, const Use& use) noexcept {
    for (std::size_t first = 0; first < count; first += paths_at_once)
        use(first, std::min<std::size_t>(paths_at_once, count - first));
}

/// `count` numbers where a kernel wants `paths_at_once`: themselves, or a copy that ends in the
/// last.
class Block {
  public:
    const float* of(const float* numbers, std::size_t count) noexcept {
        if (count == paths_at_once) return numbers;
        std::copy(numbers, numbers + count, copy_);
        std::fill(copy_ + count, copy_ + paths_at_once, numbers[count - 1]);
        return copy_;
    }

  private:
    float copy_[paths_at_once];
};

}  // namespace

template <int channels>
void SliceOf<channels>::many(const BoundSide& side, std::size_t count, const float* mu_in,
                             const float* mu_out, const float* azimuth,
                             float* value) const noexcept {
    if (side.kernel.at_angles == nullptr) {
        std::fill(value, value + channels * count, 0.0f);
        return;
    }
    const Kernels& all = kernels();
    in_blocks(count, [&](std::size_t first, std::size_t here) {
        Block in, out, around;
        LightPaths paths;
        alignas(64) float found[channels * paths_at_once];
        all.paths_of_angles[&side == transmission_.get()](in.of(mu_in + first, here),
                                                          out.of(mu_out + first, here),
                                                          around.of(azimuth + first, here), paths);
        side.kernel.many(side.view, paths, found);
        for (int c = 0; c < channels; ++c)
            std::copy(found + c * paths_at_once, found + c * paths_at_once + here,
                      value + static_cast<std::size_t>(c) * count + first);
    });
}

template <int channels>
void SliceOf<channels>::reflection(std::size_t count, const float* mu_in, const float* mu_out,
                                   const float* azimuth, float* value) const noexcept {
    many(*reflection_, count, mu_in, mu_out, azimuth, value);
}

template <int channels>
void SliceOf<channels>::transmission(std::size_t count, const float* mu_in, const float* mu_out,
                                     const float* azimuth, float* value) const noexcept {
    many(*transmission_, count, mu_in, mu_out, azimuth, value);
}

template <int channels>
void SliceOf<channels>::eval(std::size_t count, const float* const wi[3], const float* const wo[3],
                             float* value) const noexcept {
    const Kernels& all = kernels();
    in_blocks(count, [&](std::size_t first, std::size_t here) {
        Block blocks[6];
        const float *in[3], *out[3];
        for (int d = 0; d < 3; ++d) {
            in[d] = blocks[d].of(wi[d] + first, here);
            out[d] = blocks[d + 3].of(wo[d] + first, here);
        }
        LightPaths paths;
        alignas(64) float reflected[channels * paths_at_once] = {},
                                               transmitted[channels * paths_at_once] = {};
        all.paths_of_vectors(in, out, paths);
        bool any[2] = {false, false};
        for (std::size_t i = 0; i < here; ++i) any[in[2][i] * out[2][i] > 0 ? 0 : 1] = true;
        if (any[0] && reflection_->kernel.at_angles != nullptr)
            reflection_->kernel.many(reflection_->view, paths, reflected);
        if (any[1] && transmission_->kernel.at_angles != nullptr)
            transmission_->kernel.many(transmission_->view, paths, transmitted);
        for (std::size_t i = 0; i < here; ++i) {
            const float sides = in[2][i] * out[2][i];
            const bool seen = sides != 0 && (!one_sided_ || (in[2][i] > 0 && out[2][i] > 0));
            const float scale = seen ? static_cast<float>(1 / pi) : 0.0f;
            for (std::size_t c = 0; c < channels; ++c)
                value[c * count + first + i] =
                    scale * (sides > 0 ? reflected : transmitted)[c * paths_at_once + i];
        }
    });
}

template <int channels>
typename SliceOf<channels>::Value SliceOf<channels>::direct(float mu) const noexcept {
    float value[channels];
    for (int c = 0; c < channels; ++c)
        value[c] =
            one_sided_
                ? 0
                : static_cast<float>(direct_transmittance(medium_.optical_depth[c], double{mu}));
    return value_of(value, 1);
}

template <int channels>
typename SliceOf<channels>::Value SliceOf<channels>::background(float mu) const noexcept {
    float value[channels];
    for (int c = 0; c < channels; ++c)
        value[c] = one_sided_
                       ? 0
                       : static_cast<float>(transparency(double{forward_phase_}, medium_.albedo[c],
                                                         medium_.optical_depth[c], double{mu}));
    return value_of(value, 1);
}

template <int channels>
std::size_t SliceOf<channels>::bytes() const noexcept {
    std::size_t numbers = 0;
    for (const BoundSide* side : {reflection_.get(), transmission_.get()})
        numbers += side->sample.size() + side->phase.sample_count();
    return sizeof *this + 2 * sizeof(BoundSide) + numbers * sizeof(float);
}

template class SliceOf<1>;
template class SliceOf<3>;

Slice TableView::bind(double optical_depth, double albedo, const Effects& effects) const {
    return Slice(*this, {{optical_depth}, {albedo}}, effects);
}

RgbSlice TableView::bind_rgb(const double (&optical_depth)[3], const double (&albedo)[3],
                             const Effects& effects) const {
    Medium<3> medium;
    std::copy(optical_depth, optical_depth + 3, medium.optical_depth);
    std::copy(albedo, albedo + 3, medium.albedo);
    return RgbSlice(*this, medium, effects);
}

}  // namespace stratus
