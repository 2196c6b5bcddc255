#include <stratus/io/phase_file.h>

#include "refusal.h"
#include "temporary_folder.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <vector>

namespace stratus {
namespace {

class PhaseFile : public testing::Test {
  protected:
    void write(const std::string& name, const std::string& text) const {
        test::set_content(folder_ / name, text);
    }

    PhaseFunction read(const std::string& text, std::vector<std::string>* notes = nullptr) const {
        return read_phase_function(text, folder_.path().string(), notes);
    }

    test::TemporaryFolder folder_;
};

TEST_F(PhaseFile, HoldsATable) {
    write("moon.csv", "# a moon\nvalue,phase_angle_deg\n2,0\n1,90\n0.5,180\n");
    std::vector<std::string> notes;
    const PhaseFunction phi = read("tabulated:file=moon.csv", &notes);
    EXPECT_EQ(phi.text(), "tabulated:points=0 2/90 1/180 0.5");
    ASSERT_EQ(notes.size(), 1u);
    EXPECT_NE(notes[0].find("mean"), std::string::npos);
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

TEST_F(PhaseFile, IsRefusedWithTheLineThatIsWrong) {
    const auto refused = [&](const char* file, const char* text,
                             std::vector<const char*> fragments) {
        write("bad.csv", text);
        expect_refusal<std::invalid_argument>([&] { read(std::string(file) + ":file=bad.csv"); },
                                              fragments);
    };
    const std::string head = "phase_angle_deg,value\n";
    refused("tabulated", (head + "0,1\n180,1\n").c_str(), {"at least 3 rows", "got 2"});
    refused("tabulated", (head + "0,1\n90,-1\n180,1\n").c_str(),
            {"value", "bad.csv, line 3", "at least 0", "got -1"});
    refused("tabulated", (head + "0,1\n90,1\n80,1\n180,1\n").c_str(),
            {"phase_angle_deg", "bad.csv, line 4", "above the one before", "got 80"});
    refused("tabulated", (head + "0,1\n90,1\n190,1\n").c_str(), {"line 4", "[0, 180]", "190"});
    refused("tabulated", (head + "0,inf\n90,1\n180,1\n").c_str(), {"line 2", "finite", "inf"});
    refused("tabulated", "angle,value\n0,1\n", {"'phase_angle_deg'", "angle, value"});
    refused("moments", "l,chi\n0,1\n2,0.5\n", {"bad.csv, line 3", "l", "must be 1", "got 2"});
    refused("moments", "l,chi\n", {"at least one moment"});
    refused("moments", "l,chi\n0,1\n1,1.5\n", {"chi_1 (", "bad.csv, line 3", "[-1, 1]", "got 1.5"});
}

TEST_F(PhaseFile, MustHaveAName) {
    expect_refusal<std::invalid_argument>([&] { read("moments:file="); }, {"file", "nothing"});
}

TEST_F(PhaseFile, NameEndsBeforeAPlusBetweenSpaces) {
    write("haze.csv", "l,chi\n0,1\n1,0.25\n");
    expect_refusal<std::invalid_argument>([&] { read("moments:file=haze.csv + raleigh"); },
                                          {"'raleigh'", "did you mean 'rayleigh'"});
}

TEST_F(PhaseFile, IsNamedWhenItIsMissing) {
    expect_refusal<std::runtime_error>([&] { read("tabulated:file=gone.csv"); }, {"gone.csv"});
}

}  // namespace
}  // namespace stratus
