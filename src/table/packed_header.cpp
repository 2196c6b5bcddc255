#include <stratus/table/metadata.h>

#include "packed_parts.h"

#include <algorithm>
#include <optional>
#include <variant>

namespace stratus {
namespace {

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

AxisScale read_scale(const TensorFile& file, const std::string& name) {
    const std::string& text = file.text(name + scale_suffix);
    const std::optional<AxisScale> scale = axis_scale_named(text);
    require(scale.has_value(), packed_caller, name + scale_suffix, "the name of a scale",
            text.substr(0, 40));
    return *scale;
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
        static_cast<float>(to_number(path_offset_name, file.text(path_offset_name))),
        to_number(path_deepest_name, file.text(path_deepest_name)),
        static_cast<int>(orders.shape[1]) + 2, std::move(samples));
}

/// The axes of a family, whose parameters are known.
void read_family_axes(const TensorFile& file, Table& table) {
    for (FamilyAxis& axis : table.family) {
        const std::string name = axis.name();
        axis.is_discrete = file.text(name + scale_suffix) == discrete_scale_name;
        if (!axis.is_discrete) axis.axis.scale = read_scale(file, name);
        axis.axis.values = copied(file.numbers<double>(name, 1));
    }
}

}  // namespace

PhaseCurve read_phase_curve(const TensorFile& file, const std::string& name, std::size_t width,
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
            list_text(samples.shape));
    return PhaseCurve::of_samples(copied(samples), static_cast<int>(width));
}

Table packed_header(const TensorFile& file) {
    check_format(file);
    check_features_known(file.strings());
    Table table = table_of_metadata(file.strings());
    for (const AxisField& field : axis_fields) {
        const bool may_be_infinite = field.axis == &Table::optical_depth;
        table.*field.axis = {
            read_scale(file, field.name),
            copied(file.numbers<double>(field.name, 1,
                                        may_be_infinite ? Infinity::allowed : Infinity::refused))};
    }
    read_family_axes(file, table);
    for (const SampleField& field : sample_fields)
        if (field.is_flux() && file.has(field.name))
            table.*field.samples = copied(file.numbers<float>(field.name, field.rank + 1));
    table.diffusion_exponent = copied(file.numbers<double>(diffusion_exponent_name, 2));
    for (const auto& [name, text] : file.strings())
        if (!is_reserved(name)) table.attributes[name] = text;
    prepare_header(table);
    if (!table.has_family())
        table.phase_curve = read_phase_curve(file, phase_name, 1, table.phase_function);
    if (has_feature(file.strings(), path_law_feature)) {
        if (table.has_family())
            table.path_law = PathOrders::of_any(table.phase_function);
        else
            table.path_law = file.tensor(path_orders_name).type == TensorType::f16
                                 ? path_orders(file, file.numbers<Half>(path_orders_name, 2))
                                 : path_orders(file, file.numbers<float>(path_orders_name, 2));
    }
    check_features(file.strings(), table);
    return table;
}

bool is_reserved(const std::string& name) {
    static const std::vector<std::string> fixed{checksum_key, format_name, format_version_name,
                                                path_offset_name, path_deepest_name};
    if (find_entry(shared_entries, name)) return true;
    if (std::find(fixed.begin(), fixed.end(), name) != fixed.end()) return true;
    for (const std::string& parameter : parameter_names())
        if (name == parameter + scale_suffix) return true;
    return std::any_of(axis_fields.begin(), axis_fields.end(), [&](const AxisField& field) {
        return name == std::string(field.name) + scale_suffix;
    });
}

}  // namespace stratus
