#include "packed_parts.h"

#include <stratus/base/number_text.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <variant>

namespace stratus {
namespace {

double number(const TensorFile& file, const char* name) {
    const std::string& text = file.text(name);
    double value = 0;
    require(!text.empty() && read_number(text, value) == text.size(), packed_caller, name,
            "a number", '"' + text.substr(0, 40) + '"');
    return value;
}

int whole_number(const TensorFile& file, const char* name, int most) {
    const double value = number(file, name);
    require(value >= 0 && value <= most && value == std::floor(value), packed_caller, name,
            "a whole number up to " + std::to_string(most), value);
    return static_cast<int>(value);
}

template <class Number>
std::vector<Number> copied(const TensorOf<Number>& numbers) {
    return std::vector<Number>(numbers.begin(), numbers.end());
}

void check_format(const TensorFile& file) {
    const std::string& format = file.text(format_name);
    require(format == packed_format, packed_caller, format_name, packed_format,
            format.substr(0, 40));
    const std::string& version = file.text(format_version_name);
    require(version == packed_format_version, packed_caller, format_version_name,
            packed_format_version, version.substr(0, 40));
}

AxisScale scale_of(const TensorFile& file, const std::string& name) {
    const std::string& text = file.text(name + scale_suffix);
    for (const AxisScale scale :
         {AxisScale::linear, AxisScale::arcsine_of_fourth_root, AxisScale::logarithmic,
          AxisScale::square_root_of_complement, AxisScale::square_root,
          AxisScale::fourth_root_of_complement, AxisScale::logarithm_of_complement})
        if (text == axis_scale_name(scale)) return scale;
    require(false, packed_caller, name + scale_suffix, "the name of a scale", text.substr(0, 40));
    return {};
}

/// Refuses a text that names another file.
PhaseFunction complete_phase_function(const std::string& text, const char* name) {
    require(text.find("file") == std::string::npos, packed_caller, name, "complete",
            "one that names a file");
    return parse_phase_function(text);
}

PhaseFunction phase_function(const TensorFile& file, const char* name) {
    return complete_phase_function(file.text(name), name);
}

LowerBoundary lower_boundary(const TensorFile& file) {
    if (file.strings().count(below_name) == 0) return {};
    const std::string& kind = file.text(below_name);
    const double albedo = number(file, below_albedo_name);
    if (kind == surface_name) return LowerBoundary::surface(albedo);
    require(kind == layer_name, packed_caller, below_name,
            std::string(surface_name) + " or " + layer_name, kind.substr(0, 40));
    return LowerBoundary::layer(phase_function(file, below_phase_function_name), albedo);
}

std::vector<StackLayer> layers_of(const TensorFile& file) {
    std::vector<StackLayer> layers;
    if (!file.has(layers_name)) return layers;
    const TensorOf<double> numbers = file.numbers<double>(layers_name, 2, Infinity::allowed);
    require_shape(numbers, layers_name, {numbers.shape[0], 2});
    std::istringstream lines(file.text(layer_phase_functions_name));
    std::string line;
    while (layers.size() < numbers.shape[0] && std::getline(lines, line)) {
        const double* const of = numbers.data + 2 * layers.size();
        layers.push_back({complete_phase_function(line, layer_phase_functions_name), of[0], of[1]});
    }
    require(layers.size() == numbers.shape[0] && !std::getline(lines, line), packed_caller,
            layer_phase_functions_name, std::to_string(numbers.shape[0]) + " lines",
            "another number");
    return layers;
}

float as_float(float value) { return value; }
float as_float(Half value) { return to_float(value); }

template <class Number>
std::shared_ptr<const PathOrders> path_orders(const TensorFile& file,
                                              const TensorOf<Number>& orders) {
    require(orders.shape[1] < 1 << 16, packed_caller, "orders of path_orders", "below 65536",
            orders.shape[1]);
    std::vector<float> samples;
    samples.reserve(orders.count());
    for (std::size_t n = 0; n < orders.count(); ++n) samples.push_back(as_float(orders.data[n]));
    return std::make_shared<const PathOrders>(
        static_cast<float>(number(file, path_offset_name)), number(file, path_deepest_name),
        static_cast<int>(orders.shape[1]) + 2, std::move(samples));
}

/// The axes of a family, and what lookups need of its members.
void read_family(const TensorFile& file, Table& table) {
    std::vector<std::string> names;
    if (file.strings().count(family_name) != 0) {
        std::istringstream words(file.text(family_name));
        for (std::string word; names.size() <= max_family_axes && words >> word;)
            names.push_back(word);
    }
    for (const std::string& name : names) {
        const auto parameter = parameter_named(name);
        require(parameter.has_value(), packed_caller, family_name,
                "names out of " + joined(parameter_names()), name.substr(0, 40));
        const bool is_discrete = file.text(name + scale_suffix) == discrete_scale_name;
        const AxisScale scale = is_discrete ? parameter_scale(*parameter) : scale_of(file, name);
        table.family.push_back(
            {*parameter, {scale, copied(file.numbers<double>(name, 1))}, is_discrete});
        if (*parameter != PhaseParameter::mixture) continue;
        table.second_phase_function = phase_function(file, second_phase_function_name);
    }
    if (table.has_family())
        table.extrapolation_lengths = copied(file.numbers<double>(extrapolation_lengths_name, 1));
}

}  // namespace

std::string shape_text(const std::vector<std::size_t>& shape) {
    std::vector<std::string> words;
    for (const std::size_t extent : shape) words.push_back(std::to_string(extent));
    return "[" + joined(words) + "]";
}

PhaseCurve curve_of(const TensorFile& file, const std::string& name, std::size_t width,
                    const PhaseFunction& phase_function) {
    if (!file.has(name)) {
        const auto is_closed = [](const auto& part) {
            return std::visit([](const auto& kind) { return kind.closed_form().has_value(); },
                              part.second);
        };
        const auto& terms = phase_function.terms();  // asked before a curve is sampled for nothing
        require(width == 1 && std::all_of(terms.begin(), terms.end(), is_closed), packed_caller,
                name, "given", "none");
        PhaseCurve curve(phase_function);
        require(curve.sample_count() == 0, packed_caller, name, "given", "none");
        return curve;
    }
    const TensorOf<float> samples = file.numbers<float>(name, 2);
    require(samples.shape[0] >= 2 && samples.shape[0] <= (1 << 20) && samples.shape[1] == width,
            packed_caller, "shape of " + name, "[2 to 1048576, " + std::to_string(width) + "]",
            shape_text(samples.shape));
    return PhaseCurve::of_samples(copied(samples), static_cast<int>(width));
}

Table packed_header(const TensorFile& file) {
    check_format(file);
    Table table;
    table.phase_function = phase_function(file, phase_function_name);
    table.lower_boundary = lower_boundary(file);
    table.layers = layers_of(file);
    if (table.is_stack()) table.spherical_albedo_below = number(file, spherical_albedo_below_name);
    for (const PackedAxisField& field : packed_axis_fields()) {
        const bool may_be_infinite = field.axis == &Table::optical_depth;
        table.*field.axis = {
            scale_of(file, field.name),
            copied(file.numbers<double>(field.name, 1,
                                        may_be_infinite ? Infinity::allowed : Infinity::refused))};
    }
    read_family(file, table);
    table.extrapolation_length = number(file, extrapolation_length_name);
    table.tolerance = number(file, tolerance_name);
    table.measured_error = number(file, measured_error_name);
    table.highest_order = whole_number(file, highest_order_name, 1 << 20);
    for (const PackedFluxField& field : packed_flux_fields())
        if (file.has(field.name))
            table.*field.flux = copied(file.numbers<float>(field.name, field.over_mu ? 4 : 3));
    table.diffusion_exponent = copied(file.numbers<double>(diffusion_exponent_name, 2));
    for (const auto& [name, text] : file.strings())
        if (!is_reserved(name)) table.attributes[name] = text;
    prepare_header(table);
    if (!table.has_family())
        table.phase_curve = curve_of(file, phase_name, 1, table.phase_function);
    if (table.has_family() && file.strings().count(family_path_law_name) != 0)
        table.path_law = PathOrders::of_any(table.phase_function);
    if (file.has(path_orders_name)) {
        table.path_law = file.tensor(path_orders_name).type == TensorType::f16
                             ? path_orders(file, file.numbers<Half>(path_orders_name, 2))
                             : path_orders(file, file.numbers<float>(path_orders_name, 2));
    }
    return table;
}

bool is_reserved(const std::string& name) {
    static const std::vector<std::string> fixed{checksum_key,
                                                format_name,
                                                format_version_name,
                                                phase_function_name,
                                                below_name,
                                                below_albedo_name,
                                                second_phase_function_name,
                                                family_name,
                                                family_path_law_name,
                                                tolerance_name,
                                                measured_error_name,
                                                below_phase_function_name,
                                                highest_order_name,
                                                path_offset_name,
                                                extrapolation_length_name,
                                                path_deepest_name,
                                                layer_phase_functions_name,
                                                spherical_albedo_below_name};
    if (std::find(fixed.begin(), fixed.end(), name) != fixed.end()) return true;
    for (const std::string& parameter : parameter_names())
        if (name == parameter + scale_suffix) return true;
    const auto& axes = packed_axis_fields();
    return std::any_of(axes.begin(), axes.end(), [&](const PackedAxisField& field) {
        return name == std::string(field.name) + scale_suffix;
    });
}

}  // namespace stratus
