// The solver against numbers printed in the literature, to the digits printed.
#include <stratus/base/constants.h>
#include <stratus/io/table_file.h>
#include <stratus/transfer/solve.h>

#include "indices.h"
#include "usual_layers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>
#include <string>
#include <vector>

namespace stratus {
namespace {

PhaseFunction published_phase_function(const std::string& name) {
    static const std::map<std::string, std::string> texts{
        {"isotropic", "isotropic"},
        {"hg50", "henyey_greenstein:g=0.5"},
        {"hg75", "henyey_greenstein:g=0.75"},
        {"mie_l8", "moments:file=mie_l8_moments.csv"},
        {"haze_l", "moments:file=haze_l_moments.csv"},
    };
    return read_phase_function(texts.at(name), STRATUS_REFERENCE_FOLDER);
}

/// Mean over azimuth of value(azimuth) cos(mode azimuth), exact for fewer than 100 modes.
template <class Value>
double fourier(int mode, Value value) {
    constexpr int count = 200;
    double sum = 0;
    for (int k = 0; k < count; ++k) {
        const double azimuth = 2 * pi * k / count;
        sum += value(azimuth) * std::cos(mode * azimuth);
    }
    return sum / count;
}

double published_quantity(const std::map<std::string, std::string>& row) {
    const double mu0 = std::stod(row.at("mu0"));
    const std::string &quantity = row.at("quantity"), &mu = row.at("mu");
    const LayerSolution layer = solve_layer(published_phase_function(row.at("phase")),
                                            std::stod(row.at("w")), std::stod(row.at("tau")),
                                            {mu0, mu.empty() ? 1 : std::stod(mu)}, with_nodes(48));
    if (quantity == "plane_albedo") return layer.plane_albedo(0);
    if (quantity == "total_transmittance")
        return layer.diffuse_transmittance(0) + direct_transmittance(layer.optical_depth, mu0);
    const auto value = [&](double azimuth) {
        return quantity == "R" || quantity == "I_up" ? layer.reflection(0, 1, azimuth).total
                                                     : layer.transmission(0, 1, azimuth).total;
    };
    const double intensity = quantity[0] == 'I' ? mu0 : 1;
    if (row.at("mode").empty())
        return intensity *
               value(row.at("dphi_deg").empty() ? 0 : radians(std::stod(row.at("dphi_deg"))));
    const int mode = std::stoi(row.at("mode"));
    return intensity * (mode ? 2 : 1) * fourier(mode, value);
}

std::vector<std::string> fields_of(const std::string& line) {
    std::vector<std::string> fields(1);
    for (const char c : line) {
        if (c == ',')
            fields.emplace_back();
        else
            fields.back() += c;
    }
    return fields;
}

class PublishedValues : public testing::TestWithParam<const char*> {};

TEST_P(PublishedValues, AreMatchedToTheDigitsPrinted) {
    std::ifstream file(STRATUS_REFERENCE_FOLDER "/published.csv");
    std::vector<std::string> columns;
    std::string line;
    int rows = 0;
    while (std::getline(file, line)) {
        if (line[0] == '#') continue;
        const std::vector<std::string> fields = fields_of(line);
        if (columns.empty()) {
            columns = fields;
            continue;
        }
        if (fields[0] != GetParam()) continue;
        ASSERT_EQ(fields.size(), columns.size()) << line;
        std::map<std::string, std::string> row;
        for (const auto c : indices(fields)) row[columns[c]] = fields[c];
        const std::string& printed = row.at("value");
        const double unit =
            std::pow(10.0, -static_cast<double>(printed.size() - printed.find('.') - 1));
        EXPECT_NEAR(published_quantity(row), std::stod(printed), 0.51 * unit) << line;
        ++rows;
    }
    EXPECT_GE(rows, 20);
}

INSTANTIATE_TEST_SUITE_P(In, PublishedValues, testing::Values("vdH80", "GS85"),
                         [](const auto& source) { return source.param; });

}  // namespace
}  // namespace stratus
