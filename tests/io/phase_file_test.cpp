#include <stratus/io/table_file.h>

#include "refusal.h"
#include "temporary_folder.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <vector>

namespace stratus::test {
namespace {

class PhaseFile : public testing::Test {
  protected:
    void write(const std::string& name, const std::string& text) const {
        set_content(folder_ / name, text);
    }

    PhaseFunction read(const std::string& text, std::vector<std::string>* notes = nullptr) const {
        return read_phase_function(text, folder_.path().string(), notes);
    }

    TemporaryFolder folder_;
};

TEST_F(PhaseFile, HoldsATable) {
    write("moon.csv", "# a moon\nvalue,phase_angle_deg\n2,0\n1,90\n0.5,180\n");
    std::vector<std::string> notes;
    const PhaseFunction phi = read("tabulated:file=moon.csv", &notes);
    EXPECT_EQ(phi.text(), "tabulated:points=0 2/90 1/180 0.5");
    ASSERT_EQ(notes.size(), 1u);
    expect_holds(notes[0], "mean");
    EXPECT_EQ(read("tabulated:file=" + (folder_ / "moon.csv").string()).text(), phi.text());
}

TEST_F(PhaseFile, HoldsAListOfMoments) {
    write("haze.csv", "l,chi\n0,1\n1,0.5\n2,0.25\n");
    std::vector<std::string> notes;
    EXPECT_EQ(read("moments:file=haze.csv", &notes).text(), "moments:chi=1 0.5 0.25");
    EXPECT_TRUE(notes.empty());
}

TEST_F(PhaseFile, MayHavePlusSignsAndSpacesInItsName) {
    write("a+b c.csv", "l,chi\n0,1\n1,0.25\n");
    EXPECT_EQ(read("moments:file=a+b c.csv").text(), "moments:chi=1 0.25");
    const char* const sum = "0.5*moments:chi=1 0.25 + 0.5*rayleigh";
    EXPECT_EQ(read("0.5*moments:file=a+b c.csv+0.5*rayleigh").text(), sum);
    EXPECT_EQ(read("0.5*moments:file=a+b c.csv + 0.5 * rayleigh").text(), sum);
}

TEST_F(PhaseFile, MayBeFollowedByOptionsOfATable) {
    write("a,b.csv", "phase_angle_deg,value\n10,2\n40,1.5\n60,1\n90,1\n120,0.6\n150,0.5\n");
    std::vector<std::string> notes;
    const PhaseFunction phi =
        read("0.5*tabulated:file=a,b.csv,geometric_albedo=1e-1,tail=hg + 0.5*rayleigh", &notes);
    EXPECT_EQ(
        phi.text(),
        "0.5*tabulated:points=10 2/40 1.5/60 1/90 1/120 0.6/150 0.5,tail=hg,geometric_albedo=0.1 + "
        "0.5*rayleigh");
    ASSERT_EQ(notes.size(), 2u);  // how it is continued; values are scaled
    EXPECT_TRUE(read("tabulated:file=a,b.csv,geometric_albedo=0.1").albedo().has_value());
    const char* const moments = "moments:file=m,tail=hg";
    write("m,tail=hg", "l,chi\n0,1\n1,0.25\n");
    EXPECT_EQ(read(moments).text(), "moments:chi=1 0.25");
}

TEST_F(PhaseFile, HoldsValuesAtEitherAngle) {
    write("moon.csv", "phase_angle_deg,value\n0,2\n80,1.5\n150,0.5\n");
    write("same.csv", "value,scattering_angle_deg\n0.5,30\n1.5,100\n2,180\n");
    EXPECT_EQ(read("tabulated:file=same.csv").text(), read("tabulated:file=moon.csv").text());
}

TEST_F(PhaseFile, IsRefusedWithTheLineThatIsWrong) {
    const auto refused = [&](const char* file, const std::string& text, const Fragments& parts) {
        write("bad.csv", text);
        expect_refusal([&] { read(std::string(file) + ":file=bad.csv"); }, parts);
    };
    for (const std::string angle : {"phase_angle_deg", "scattering_angle_deg"}) {
        const std::string head = angle + ",value\n";
        refused("tabulated", head + "0,1\n180,1\n", "at least 3 rows, got 2");
        refused("tabulated", head + "0,1\n90,-1\n180,1\n",
                {"value", "bad.csv, line 3", "at least 0", "got -1"});
        refused("tabulated", head + "0,1\n90,1\n80,1\n180,1\n",
                {angle, "bad.csv, line 4", "above the one before", "got 80"});
        refused("tabulated", head + "0,1\n90,1\n190,1\n", "line 4) must be in [0, 180], got 190");
        refused("tabulated", head + "0,inf\n90,1\n180,1\n",
                "line 2) must be finite and at least 0, got inf");
    }
    refused("tabulated", "phase_angle_deg,scattering_angle_deg,value\n0,180,1\n",
            "bad.csv: columns must be phase_angle_deg or scattering_angle_deg, got both");
    refused("tabulated", "angle,value\n0,1\n", "'phase_angle_deg' must be there, got angle, value");
    refused("moments", "l,chi\n0,1\n2,0.5\n", {"bad.csv, line 3", "l", "must be 1", "got 2"});
    refused("moments", "l,chi\n", "at least one moment");
    refused("moments", "l,chi\n0,1\n1,1.5\n", {"chi_1 (", "bad.csv, line 3", "[-1, 1]", "got 1.5"});
}

TEST_F(PhaseFile, HoldsTheIndexAndTheSizesOfDroplets) {
    write("my acid, 25 C+.csv", "# an acid\nk,n,wavelength_um\n0.01,1.5,0.5\n0.02,1.4,1\n");
    write("drops.csv", "radius_um,number_per_um\n0.1,0\n0.2,5\n0.4,1\n");
    const std::string sizes = "mie:distribution=0.1 0/0.2 5/0.4 1,wavelength=1um,";
    EXPECT_EQ(read("mie:distribution=drops.csv,wavelength=1um,index=my acid, 25 C+.csv").text(),
              sizes + "index=1.4+0.02i");
    EXPECT_EQ(read("mie:index=my acid, 25 C+.csv,distribution=drops.csv,wavelength=1um").text(),
              sizes + "index=1.4+0.02i");
    EXPECT_EQ(read("0.5*mie:distribution=drops.csv,wavelength=1um+0.5*rayleigh").text(),
              "0.5*" + sizes + "material=water + 0.5*rayleigh");
    const PhaseFunction between = read("mie:radius=1um,wavelength=0.7um,index=my acid, 25 C+.csv");
    const PhaseFunction again = parse_phase_function(between.text());
    EXPECT_EQ(again.text(), between.text());
    EXPECT_EQ(again.moments(30), between.moments(30));
}

TEST_F(PhaseFile, OfDropletsIsRefusedWithTheLineThatIsWrong) {
    const auto refused = [&](const char* parameter, const char* text, Fragments fragments) {
        write("bad.csv", text);
        const std::string radius = parameter == std::string("index") ? ",radius=1um" : "";
        expect_refusal([&] { read(std::string("mie:") + parameter + "=bad.csv" + radius); },
                       fragments);
    };
    refused("index", "wavelength_um,n,k\n0.4,1.3,0\n0.4,1.3,0\n",
            {"wavelength_um", "bad.csv, line 3", "above the one before", "got 0.4"});
    refused("index", "wavelength_um,n,k\n0.4,1.3,0\n0.7,1.3,-1\n",
            {"k (", "bad.csv, line 3", "[0, 10]", "got -1"});
    refused("index", "wavelength_um,n,k\n0.6,1.3,0\n0.7,1.3,0\n",
            {"wavelength must be in [0.6, 0.7] um", "bad.csv", "got 0.55"});
    refused("index", "wavelength,n,k\n0.6,1.3,0\n",
            "'wavelength_um' must be there, got wavelength, n, k");
    refused("distribution", "radius_um,number_per_um\n1,1\n# none\n2,-3\n",
            {"number_per_um", "bad.csv, line 4", "at least 0", "got -3"});
    refused("distribution", "radius_um,number_per_um\n2,1\n1,1\n",
            {"radius_um", "bad.csv, line 3", "above the one before", "got 1"});
    refused("distribution", "radius,number\n2,1\n",
            "'radius_um' must be there, got radius, number");
    expect_refusal<std::runtime_error>([&] { read("mie:distribution=gone.csv"); }, "gone.csv");
}

TEST_F(PhaseFile, MustHaveAName) {
    expect_refusal([&] { read("moments:file="); }, "file=': file must be a name, got nothing");
}

TEST_F(PhaseFile, NameEndsBeforeAPlusBetweenSpaces) {
    write("haze.csv", "l,chi\n0,1\n1,0.25\n");
    expect_refusal([&] { read("moments:file=haze.csv + raleigh"); },
                   "'raleigh'; did you mean 'rayleigh'");
}

TEST_F(PhaseFile, IsNamedWhenItIsMissing) {
    expect_refusal<std::runtime_error>([&] { read("tabulated:file=gone.csv"); }, "gone.csv");
}

}  // namespace
}  // namespace stratus::test
