#include <stratus/table/ground.h>

#include <stratus/base/argument.h>
#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>
#include <stratus/table/lookup.h>
#include <stratus/table/packed_table.h>

#include "layer_coverage.h"
#include "phase/kinds/phase_text.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <string_view>

namespace stratus {
namespace {

constexpr const char* ground_caller = "ground";
constexpr std::string_view table_form = "table:";

class TableGround final : public GroundLaw {
  public:
    TableGround(std::string text, const std::string& path, std::optional<double> optical_depth,
                std::optional<double> albedo)
        : text_(std::move(text)), packed_(path), view_(packed_.view()) {
        require(!view_.has_family() && view_.has_reflection() && view_.has_all_directions(),
                ground_caller, "table", "one without a family, of reflection in all directions",
                text_);
        optical_depth_ = chosen(optical_depth, view_.optical_depth, "optical_depth");
        albedo_ = chosen(albedo, view_.albedo, "albedo");
        once_ = is_scattered_once(view_, albedo_, optical_depth_);
        if (once_) return;
        require(is_depth_known(view_, Side::reflection, albedo_, optical_depth_), ground_caller,
                "optical_depth", allowed_depth(view_), optical_depth_);
        require(holds(view_.albedo, albedo_), ground_caller, "albedo", allowed_albedo(view_),
                albedo_);
    }

    double operator()(const Geometry& at) const noexcept override {
        const auto one_way = [&](const Geometry& way) {
            const Scattered light = reflection(view_, albedo_, optical_depth_, way);
            return once_ ? light.single : light.total();
        };
        return view_.is_symmetric()
                   ? one_way(at)
                   : (one_way(at) + one_way({at.mu_out, at.mu_in, at.azimuth})) / 2;
    }

    std::string text() const override { return text_; }

  private:
    static double chosen(std::optional<double> given, const AxisView& axis, const char* name) {
        if (given) return *given;
        if (axis.count == 0) return infinity;  // of optical depth alone
        require(axis.count == 1, ground_caller, name, "given, for the table holds several", "none");
        return axis.lowest;
    }

    std::string text_;
    PackedTable packed_;
    TableView view_;
    double optical_depth_ = 0, albedo_ = 0;
    bool once_ = false;  // scattered once alone: the samples do not count
};

std::shared_ptr<const GroundLaw> read_table_ground(const std::string& text,
                                                   const std::string& directory) {
    PhaseText rest{text, table_form.size(), {}, ground_caller};
    rest.parameter("table", {"file"});
    const std::size_t comma = std::min(text.find(',', rest.at), text.size());
    const std::string file = text.substr(rest.at, comma - rest.at);
    rest.at = comma;
    std::optional<double> optical_depth, albedo;
    while (rest.accept(',')) {
        const std::string name = rest.parameter("table", {"optical_depth", "albedo"});
        (name == "albedo" ? albedo : optical_depth) = rest.number("table: " + name);
    }
    const bool is_relative = !directory.empty() && file.rfind('/', 0) != 0;
    return std::make_shared<TableGround>(text, is_relative ? directory + '/' + file : file,
                                         optical_depth, albedo);
}

}  // namespace

LowerBoundary read_ground(const std::string& text, const std::string& directory) {
    double albedo = 0;
    if (!text.empty() && read_number(text, albedo) == text.size()) {
        require(albedo >= 0 && albedo <= 1, ground_caller, "albedo", "in [0, 1]", albedo);
        return LowerBoundary::surface(albedo);
    }
    const bool is_table = text.rfind(table_form, 0) == 0;
    require(is_table || text.find(':') != std::string::npos, ground_caller, "kind",
            "an albedo, ocean:wind=..., rpv:rho0=...,k=...,theta=... or table:file=...", text);
    return LowerBoundary::ground(is_table ? read_table_ground(text, directory)
                                          : read_ground_law(text));
}

std::string ground_help() {
    return ground_law_help() +
           "\ntable:file=T.stratus,optical_depth=4,albedo=0.9   a layer of a packed table";
}

}  // namespace stratus
