#include <stratus/io/csv.h>

#include "refusal.h"
#include "row_name.h"

#include <gtest/gtest.h>

#include <cmath>
#include <ctime>
#include <filesystem>
#include <istream>
#include <sstream>
#include <stdexcept>
#include <streambuf>
#include <vector>

namespace stratus {
namespace {

using Rows = std::vector<std::vector<double>>;
using Columns = std::vector<std::string>;

CsvTable read(const std::string& text) {
    std::istringstream stream(text);
    return read_csv(stream, "some.csv");
}

TEST(Csv, KeepsColumnsRowsAndLineNumbers) {
    const CsvTable table = read("# phases\n\nvalue, angle\n1.5,0\n# middle\n2,90\n");
    EXPECT_EQ(table.columns, (Columns{"value", "angle"}));
    EXPECT_EQ(table.column("angle"), 1);
    EXPECT_TRUE(table.has_column("value"));
    EXPECT_FALSE(table.has_column("Value"));
    EXPECT_EQ(table.rows, (Rows{{1.5, 0}, {2, 90}}));
    EXPECT_EQ(table.lines, (std::vector<int>{4, 6}));
}

TEST(Csv, SkipsByteOrderMarkAndCarriageReturns) {
    const CsvTable table = read("\xEF\xBB\xBFl,chi\r\n0, 1\r\n1,+2.5e-1 \r\n");
    EXPECT_EQ(table.columns, (Columns{"l", "chi"}));
    EXPECT_EQ(table.rows, (Rows{{0, 1}, {1, 0.25}}));
}

TEST(Csv, ReadsManyColumnsInLinearTime) {  // 200,000 took 22 s
    std::string header = "c0", row = "0";
    for (int c = 1; c < 200'000; ++c) header += ",c" + std::to_string(c), row += ",1";
    const std::clock_t begin = std::clock();
    EXPECT_EQ(read(header + '\n' + row + '\n').columns.size(), 200'000U);
    EXPECT_LT(std::clock() - begin, 5 * CLOCKS_PER_SEC);
}

TEST(Csv, RefusesDevicesWithoutEnd) {
    if (!std::filesystem::is_character_file("/dev/zero")) GTEST_SKIP() << "no /dev/zero here";
    expect_refusal([] { read_csv("/dev/zero"); },
                   "/dev/zero, line 1: must have at most 67108864 bytes");
}

/// Comments without end.
class Comments : public std::streambuf {
    int_type underflow() override {
        setg(line_, line_, line_ + 2);
        return line_[0];
    }
    char line_[2] = {'#', '\n'};
};

TEST(Csv, RefusesStreamsWithoutEnd) {
    Comments comments;
    std::istream stream(&comments);
    expect_refusal([&] { read_csv(stream, "standard input"); },
                   {"standard input, line 33554433", "must have at most 67108864 bytes, got more"});
}

TEST(Csv, ShowsNoControlCharacters) {
    expect_refusal([] { read("x\n\x1b[2J\n"); }, "got '\\x1b[2J'");
}

TEST(Csv, ReadsCorrectlyRoundedNumbersAndInfinity) {
    EXPECT_EQ(read("x\n0.1234567890123456789\n").rows[0][0], 0.1234567890123456789);
    EXPECT_TRUE(std::isinf(read("tau\ninf\n").rows[0][0]));
}

TEST(Csv, ReadsQuotedFields) {
    const CsvTable table = read("\"mu_in\",\"remarks, \"\"many\"\"\"\n\"0.5\", 2\n");
    EXPECT_EQ(table.columns, (Columns{"mu_in", "remarks, \"many\""}));
    EXPECT_EQ(table.rows, (Rows{{0.5, 2}}));
}

TEST(Csv, MayLackTheLastLineBreakAndRows) {
    EXPECT_EQ(read("a\n1\n2").rows, (Rows{{1}, {2}}));
    EXPECT_TRUE(read("a,b\n").rows.empty());
}

TEST(Csv, SkipsCommentsAfterBlanks) {
    EXPECT_EQ(read("a\n  # one\n1\n \t\r\n2\n").lines, (std::vector<int>{3, 5}));
}

class CsvRefuses : public testing::TestWithParam<Refusal> {};

TEST_P(CsvRefuses, NamingFileLineAndText) {
    expect_refusal([] { read(GetParam().text); }, GetParam().fragments);
}

INSTANTIATE_TEST_SUITE_P(
    Each, CsvRefuses,
    testing::ValuesIn<Refusal>(
        {{"ShortRow", "a,b\n1,2\n3\n", "some.csv, line 3: a row must have 2 values, got 1"},
         {"LongRow", "a,b\n1,2,3\n", "some.csv, line 2: a row must have 2 values, got 3"},
         {"Word", "a,b\n1,two\n", "some.csv, line 2: column 'b' must be a number, got 'two'"},
         {"HalfNumber", "a\n1.5x\n", "line 2: column 'a' must be a number, got '1.5x'"},
         {"EmptyField", "a,b\n1,\n", "line 2: column 'b' must be a number, got ''"},
         {"NotANumber", "a\nnan\n", "line 2: column 'a' must be a number, got 'nan'"},
         {"DecimalComma", "a\n1;5\n", "line 2: column 'a' must be a number, got '1;5'"},
         {"OpenQuote", "a,b\n1,\"2\n", "some.csv, line 2: a quoted field must end"},
         {"Overflow", "a\n1e999\n", "line 2: column 'a' must be a number, got '1e999'"},
         {"NoHeader", "1,2\n3,4\n",
          "some.csv, line 1: a header naming the columns must come first, got '1'"},
         {"Nothing", "# only\n\n",
          "some.csv: a header naming the columns must come first, got nothing"},
         {"NamelessColumn", "a,,b\n", "line 1: a column has no name"},
         {"ColumnTwice", "a,b,a\n", "line 1: column 'a' appears twice"}}),
    row_name);

TEST(Csv, RefusesAZeroByteWithItsLine) {
    expect_refusal([] { read(std::string("a,b\n1,2\0,3\n", 12)); },
                   "some.csv, line 2: must be text, got a byte 0");
}

TEST(Csv, ReadsColumnsOfWordsAsTheirPlaces) {
    const std::vector<CsvWords> words{{"side", {"lit", "unlit"}}};
    std::istringstream stream("mu,side\n0.5,unlit\n1, \"lit\"\n");
    const CsvTable table = read_csv(stream, "some.csv", words);
    EXPECT_EQ(table.rows, (Rows{{0.5, 1}, {1, 0}}));
    std::istringstream other("mu,side\n0.5,dark\n");
    expect_refusal([&] { read_csv(other, "some.csv", words); },
                   "some.csv, line 2: column 'side' must be one of lit, unlit, got 'dark'");
}

TEST(Csv, NamesTheColumnsPresentWhenOneIsMissing) {
    expect_refusal([] { read("mu_in,mu_out\n").column("azimuth_deg"); },
                   "some.csv: column 'azimuth_deg' must be there, got mu_in, mu_out");
}

TEST(Csv, NamesAFileThatCannotBeOpened) {
    expect_refusal<std::runtime_error>([] { read_csv("no/such/file.csv"); },
                                       "no/such/file.csv: cannot be opened");
}

}  // namespace
}  // namespace stratus
