#include <stratus/base/tensor_file.h>

#include "indices.h"
#include "refusal.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

namespace stratus {
namespace {

constexpr float infinite = std::numeric_limits<float>::infinity();

std::string text_of(const std::vector<char>& bytes) { return {bytes.begin(), bytes.end()}; }

/// A file with this header and this many zeros after it.
std::vector<char> forged(const std::string& header, std::size_t data_bytes = 0) {
    const std::uint64_t length = header.size();
    std::vector<char> file(sizeof length + header.size() + data_bytes);
    std::memcpy(file.data(), &length, sizeof length);
    std::ranges::copy(header, file.begin() + sizeof length);
    return file;
}

TensorFile read(const std::vector<char>& file) { return {file.data(), file.size()}; }

void expect_refused(const std::vector<char>& file, const std::string& sentence) {
    expect_refusal([&] { read(file); }, {"TensorFile: " + sentence});
}

/// Spaces behind the header, so that the data start at a multiple of 8 bytes.
std::string padded(std::string header) {
    header.append((8 - header.size() % 8) % 8, ' ');
    return header;
}

/// A file with one tensor "a" of these fields.
std::vector<char> one_tensor(const std::string& fields, std::size_t data_bytes) {
    return forged(padded("{\"a\":{" + fields + "}}"), data_bytes);
}

std::vector<char> sample_file() {
    TensorWriter writer;
    writer.set("format", "sample");
    writer.set("title", "\u03c4 = \"8\"\n");
    writer.add("angle", {3}, std::vector<double>{0, 0.5, infinite});
    writer.add("coefficient", {2, 1, 3}, std::vector<float>{1, -2, 3, 4, 5.5f, 0});
    writer.add("function", {5}, std::vector<Half>{{0}, {0x3c00}, {0xbc00}, {0x7bff}, {1}});
    writer.add("one", {}, std::vector<std::int32_t>{-7});
    return writer.finish();
}

TEST(TensorFile, HoldsWhatWasWritten) {
    const std::vector<char> bytes = sample_file();
    const TensorFile file = read(bytes);
    EXPECT_EQ(file.strings().size(), 3u);  // and the checksum
    EXPECT_EQ(file.text("format"), "sample");
    EXPECT_EQ(file.text("title"), "\u03c4 = \"8\"\n");
    EXPECT_TRUE(file.has("angle"));
    EXPECT_FALSE(file.has("format"));

    const auto angle = file.numbers<double>("angle", 1, Infinity::allowed);
    EXPECT_EQ(std::vector<double>(angle.begin(), angle.end()),
              (std::vector<double>{0, 0.5, infinite}));
    const auto coefficient = file.numbers<float>("coefficient", 3);
    EXPECT_EQ(coefficient.shape, (std::vector<std::size_t>{2, 1, 3}));
    EXPECT_EQ(std::vector<float>(coefficient.begin(), coefficient.end()),
              (std::vector<float>{1, -2, 3, 4, 5.5f, 0}));
    const auto function = file.numbers<Half>("function", 1);
    ASSERT_EQ(function.count(), 5u);
    EXPECT_EQ(to_float(function.data[2]), -1);
    EXPECT_EQ(to_float(function.data[3]), largest_half);
    const auto one = file.numbers<std::int32_t>("one", 0);
    ASSERT_EQ(one.count(), 1u);
    EXPECT_EQ(one.data[0], -7);
}

TEST(TensorFile, IsLaidOutInOrderAtMultiplesOf64BytesWithoutGaps) {
    const std::vector<char> bytes = sample_file();
    const TensorFile file = read(bytes);
    const char* previous = bytes.data();
    for (const char* const name : {"angle", "coefficient", "function", "one"}) {
        const auto* const start = static_cast<const char*>(file.tensor(name).data);
        EXPECT_EQ((start - bytes.data()) % 64, 0) << name;
        EXPECT_GT(start, previous) << name;
        previous = start;
    }
    // Three gaps, each filled by a tensor of zeros.
    EXPECT_EQ(file.tensors().size(), 7u);
    for (const char* const name : {"padding_1", "padding_2", "padding_3"})
        for (const Half number : file.numbers<Half>(name, 1)) EXPECT_EQ(number.bits, 0) << name;
    EXPECT_EQ(file.tensor("padding_1").count(), (64u - 3 * 8) / 2);
    EXPECT_EQ(text_of(sample_file()), text_of(bytes));
}

TEST(TensorFile, CanBeEmpty) {
    const std::vector<char> bytes = TensorWriter().finish();
    EXPECT_EQ(bytes.size(), 64u);
    EXPECT_TRUE(read(bytes).tensors().empty());
    EXPECT_TRUE(read(forged("{}")).strings().empty());
}

TEST(TensorFile, KeepsEveryText) {
    std::string all;
    for (char letter = 0; letter < 127; ++letter) all += letter;
    all += "\x7f \u00e9 \u20ac \uffff \U0001f308 \U0010ffff";
    TensorWriter writer;
    writer.set(all, all);
    writer.set("", "");
    writer.add(all, {1}, std::vector<float>{1});
    const std::vector<char> bytes = writer.finish();
    const TensorFile file = read(bytes);
    EXPECT_EQ(file.text(all), all);
    EXPECT_EQ(file.text(""), "");
    EXPECT_EQ(file.numbers<float>(all, 1).data[0], 1);
}

TEST(TensorFile, ReadsWhatOthersWrite) {
    // Spaces, fields in another order, escapes, tensors in another order, and less alignment.
    const std::vector<char> bytes = forged(
        padded("{ \"b\" : {\"shape\":[ 1,\t2 ],\n\"data_offsets\":[4,12],\r\"dtype\":\"F32\"} ,"
               "\"__metadata__\":{\"k\\u0061\\n\\/\" : \"\\u00e9\\u20AC\\ud83c\\udf08\"},"
               "\"a\":{\"dtype\":\"F16\",\"shape\":[2],\"data_offsets\":[0,4]}}"),
        12);
    const TensorFile file = read(bytes);
    EXPECT_EQ(file.text("ka\n/"), "\u00e9\u20ac\U0001f308");
    EXPECT_EQ(file.tensor("b").shape, (std::vector<std::size_t>{1, 2}));
    EXPECT_EQ(file.tensor("b").data, bytes.data() + bytes.size() - 8);
    EXPECT_EQ(file.tensor("a").data, bytes.data() + bytes.size() - 12);
}

TEST(TensorFile, RefusesLengthsThatAreNot) {
    expect_refused({}, "the file must be of at least 8 bytes, got 0");
    expect_refused({1, 0, 0}, "the file must be of at least 8 bytes, got 3");
    std::vector<char> file = forged("{}", 0);
    file[0] = 3;
    expect_refused(file, "the length of the header must be at most 2 bytes, got 3");
    file = forged("{}", 100);
    std::fill_n(file.begin(), 8, '\xff');
    expect_refused(file,
                   "the length of the header must be at most 102 bytes, got 18446744073709551615");
    file = forged("{}" + std::string(max_tensor_header - 2, ' '));
    EXPECT_NO_THROW(read(file));
    file = forged("{}" + std::string(max_tensor_header - 1, ' '));
    expect_refused(file, "the length of the header must be at most 16777216 bytes, got 16777217");
    file = forged("{}");
    file[0] = 0;
    expect_refused(file, "the header must be a JSON object from its first byte on, got nothing");
}

TEST(TensorFile, RefusesDataThatAreNotAligned) {
    const std::vector<char> file = sample_file();
    std::vector<double> room(file.size() / sizeof(double) + 2);
    char* const start = reinterpret_cast<char*>(room.data()) + 4;
    std::ranges::copy(file, start);
    expect_refusal([&] { TensorFile(start, file.size()); },
                   "TensorFile: data must be aligned to 8 bytes, got 0x");
}

TEST(TensorFile, RefusesWhatIsNotTheJsonOfAHeader) {
    const auto refused = [](const std::string& header, const std::string& sentence) {
        SCOPED_TRACE(header);
        expect_refused(forged(header), sentence);
    };
    refused(" {}", "the header must be a JSON object from its first byte on, got ' '");
    refused("[]", "the header must be a JSON object from its first byte on, got '['");
    refused("{", "byte 9 of the file must be '\"', got the end of the header");
    refused("{}}", "byte 10 of the file must be a space up to the end of the header, got '}'");
    refused(std::string("{}\0", 3),
            "byte 10 of the file must be a space up to the end of the header, got '\\x00'");
    refused("{a:1}", "byte 9 of the file must be '\"', got 'a'");
    refused("{\"a\"}", "byte 12 of the file must be ':', got '}'");
    refused("{\"a\":1}", "byte 13 of the file must be '{', got '1'");
    refused("{\"a\":null}", "byte 13 of the file must be '{', got 'n'");
    refused("{\"a\":[[]]}", "byte 13 of the file must be '{', got '['");
    refused("{\"a\":{\"dtype\":{}}}", "byte 22 of the file must be '\"', got '{'");
    refused("{\"__metadata__\":{\"a\":1}}", "byte 29 of the file must be '\"', got '1'");
    refused("{\"__metadata__\":{\"a\":{}}}", "byte 29 of the file must be '\"', got '{'");
    refused("{\"__metadata__\":{},}", "byte 27 of the file must be '\"', got '}'");
    refused("{\"__metadata__\":{} \"a\":{}}", "byte 27 of the file must be '}', got '\"'");
    refused("{\"__metadata__\":{/**/}}", "byte 25 of the file must be '\"', got '/'");
    refused("{\"__metadata__\":\"\"}", "byte 24 of the file must be '{', got '\"'");
}

TEST(TensorFile, RefusesStringsThatAreNotJson) {
    // The string starts at byte 29; its first character is byte 30.
    const auto refused = [](const std::string& text, const std::string& sentence) {
        SCOPED_TRACE(text);
        expect_refused(forged("{\"__metadata__\":{\"a\":\"" + text), sentence);
    };
    const auto not_utf8 = [&](const std::string& text) {
        refused(text + "\"}}", "the string from byte 29 of the file must be UTF-8, got '");
    };
    refused("b", "byte 31 of the file must be a character of a string or '\"', got the end of");
    refused("b\n", "byte 31 of the file must be a character of a string or '\"', got '\\x0a'");
    refused(std::string(1, '\0'), "byte 30 of the file must be a character of a string");
    refused("\\", "byte 31 of the file must be one of \"\\/bfnrtu after '\\', got the end");
    refused("\\x", "byte 31 of the file must be one of \"\\/bfnrtu after '\\', got 'x'");
    refused(std::string("\\\0", 2), "byte 31 of the file must be one of \"\\/bfnrtu after '\\'");
    refused("\\u12", "byte 34 of the file must be a hexadecimal digit, got the end");
    refused("\\u12g4", "byte 34 of the file must be a hexadecimal digit, got 'g'");
    for (const char* const half : {"\\ud800\"", "\\udc00\"", "\\ud800\\ud800", "\\ud800\\u0041",
                                   "\\udc00\\ud800", "\\udbff\\"})
        refused(half,
                "the character from byte 31 of the file must be one, or a pair of "
                "surrogates, got half a pair");
    // Continuations alone, missing ones, overlong forms, surrogates, beyond U+10FFFF.
    for (const char* const text :
         {"\x80", "\xbf", "\xc3", "\xe2\x82", "\xf0\x9f\x8c", "\xc3(", "\xc0\x80", "\xc1\xbf",
          "\xe0\x9f\xbf", "\xf0\x8f\xbf\xbf", "\xed\xa0\x80", "\xed\xbf\xbf", "\xf4\x90\x80\x80",
          "\xf8\x88\x80\x80\x80", "\xff", "\xc3\\u00a9"})
        not_utf8(text);
    // The last before and the first after what was refused.
    for (const char* const text : {"\x7f", "\xc2\x80", "\xe0\xa0\x80", "\xf0\x90\x80\x80",
                                   "\xed\x9f\xbf", "\xee\x80\x80", "\xf4\x8f\xbf\xbf"}) {
        const std::vector<char> file =
            forged("{\"__metadata__\":{\"a\":\"" + std::string(text) + "\"}}");
        EXPECT_EQ(read(file).text("a"), text);
    }
}

TEST(TensorFile, RefusesNumbersThatAreNotIntegers) {
    // The list starts at byte 22, its first number at byte 23.
    const auto refused = [](const std::string& numbers, const std::string& sentence) {
        SCOPED_TRACE(numbers);
        expect_refused(forged("{\"a\":{\"shape\":[" + numbers), sentence);
    };
    refused("", "byte 23 of the file must be a digit, got the end of the header");
    refused("-1", "byte 23 of the file must be a digit, got '-'");
    refused("+1", "byte 23 of the file must be a digit, got '+'");
    refused("1,]", "byte 25 of the file must be a digit, got ']'");
    refused("1.5", "byte 24 of the file must be ']', got '.'");
    refused("1e3", "byte 24 of the file must be ']', got 'e'");
    refused("1 2", "byte 25 of the file must be ']', got '2'");
    refused("01", "the number from byte 23 of the file must be without leading zeros, got '01'");
    refused("00", "the number from byte 23 of the file must be without leading zeros, got '00'");
    refused("18446744073709551616",
            "the number from byte 23 of the file must be at most 18446744073709551615, got more");
    refused("99999999999999999999999",
            "the number from byte 23 of the file must be at most 18446744073709551615, got more");
    refused("18446744073709551615,",
            "byte 44 of the file must be a digit, got the end of the header");
    refused("1,1,1,1,1,1,1,1,1]",
            "the list from byte 22 of the file must be at most 8 numbers, got more");
}

TEST(TensorFile, RefusesFieldsThatAreNot) {
    constexpr char type[] = "\"dtype\":\"F32\"", shape[] = "\"shape\":[2,3]",
                   offsets[] = "\"data_offsets\":[0,24]";
    const auto refused = [](const std::string& fields, const std::string& sentence) {
        SCOPED_TRACE(fields);
        expect_refused(one_tensor(fields, 24), sentence);
    };
    const auto list = [](const std::vector<std::string>& fields) {
        std::string text;
        for (const std::string& field : fields) text += (text.empty() ? "" : ",") + field;
        return text;
    };
    EXPECT_NO_THROW(read(one_tensor(list({type, shape, offsets}), 24)));
    refused(list({shape, offsets}), "dtype of tensor 'a' must be given, got none");
    refused(list({type, offsets}), "shape of tensor 'a' must be given, got none");
    refused(list({type, shape}), "data_offsets of tensor 'a' must be given, got none");
    refused(list({type, shape, offsets, type}), "dtype of tensor 'a' must be given once, got two");
    refused(list({shape, shape}), "shape of tensor 'a' must be given once, got two");
    refused(list({offsets, offsets}), "data_offsets of tensor 'a' must be given once, got two");
    refused("\"strides\":[1]",
            "a field of tensor 'a' must be dtype, shape or data_offsets, got 'strides'");
    for (const char* const other : {"BF16", "U8", "f32", "F32 ", ""})
        refused(
            "\"dtype\":\"" + std::string(other) + '"',
            "dtype of tensor 'a' must be F16, F32, F64 or I32, got '" + std::string(other) + '\'');
    refused(list({type, shape, "\"data_offsets\":[0]"}),
            "data_offsets of tensor 'a' must be two numbers, got [0]");
    refused("\"data_offsets\":[0,1,2]",
            "the list from byte 29 of the file must be at most 2 numbers, got more");
}

TEST(TensorFile, RefusesNamesGivenTwice) {
    expect_refused(forged("{\"__metadata__\":{},\"__metadata__\":{}}"),
                   "__metadata__ must be given once, got two");
    expect_refused(forged("{\"__metadata__\":{\"a\":\"\",\"\\u0061\":\"b\"}}"),
                   "string 'a' must be given once, got two");
    const std::string tensor = R"("a":{"dtype":"F16","shape":[1],"data_offsets":[0,2]})";
    expect_refused(forged("{" + tensor + "," + tensor + "}", 2),
                   "tensor 'a' must be given once, got two");
}

TEST(TensorFile, RefusesExtentsThatAreNot) {
    const auto refused = [](const std::string& type, const std::string& shape,
                            const std::string& offsets, std::size_t data_bytes,
                            const std::string& sentence) {
        SCOPED_TRACE(sentence);
        expect_refused(one_tensor("\"dtype\":\"" + type + "\",\"shape\":" + shape +
                                      ",\"data_offsets\":" + offsets,
                                  data_bytes),
                       sentence);
    };
    refused("F32", "[2,3]", "[24,0]", 24,
            "data_offsets of tensor 'a' must be in ascending order, got [24, 0]");
    refused("F32", "[2,3]", "[0,24]", 23,
            "data_offsets of tensor 'a' must be within the 23 bytes of data, got [0, 24]");
    refused("F32", "[1]", "[18446744073709551612,18446744073709551615]", 8,
            "data_offsets of tensor 'a' must be within the 8 bytes of data, got");
    refused("F32", "[0,3]", "[0,0]", 0,
            "shape of tensor 'a' must be of numbers of at least 1, got [0, 3]");
    // Products that wrap around to 6 and to 0.
    refused("F32", "[6148914691236517206,3]", "[0,8]", 8, "shape of tensor 'a' must be of at most");
    refused("F32", "[4294967296,4294967296]", "[0,0]", 0, "shape of tensor 'a' must be of at most");
    refused("F64", "[2305843009213693952]", "[0,0]", 0, "shape of tensor 'a' must be of at most");
    refused("F64", "[1152921504606846975]", "[0,0]", 0,
            "data_offsets of tensor 'a' must be 9223372036854775800 bytes apart, as its shape "
            "[1152921504606846975] of F64, got [0, 0]");
    refused("F16", "[2,3]", "[0,24]", 24,
            "data_offsets of tensor 'a' must be 12 bytes apart, as its shape [2, 3] of F16, got "
            "[0, 24]");
    refused("F32", "[2,3]", "[0,20]", 24, "data_offsets of tensor 'a' must be 24 bytes apart");
    refused("I32", "[2,3]", "[0,24]", 25, "the data must be 24 bytes, as its tensors, got 25");
    refused("F64", "[3]", "[8,32]", 32,
            "data_offsets of tensor 'a' must be from 0, where the tensor before it ends, got "
            "[8, 32]");
    expect_refused(forged("{}", 1), "the data must be 0 bytes, as its tensors, got 1");
    expect_refused(forged(R"({ "a":{"dtype":"F32","shape":[1],"data_offsets":[0,4]}})", 4),
                   "the start of tensor 'a' must be a multiple of 4 bytes, got 63");
}

TEST(TensorFile, RefusesTensorsThatOverlapOrLeaveGaps) {
    const auto two = [](const std::string& first, const std::string& second) {
        return forged(padded(R"({"a":{"dtype":"F32","shape":[2],"data_offsets":)" + first +
                             R"(},"b":{"dtype":"I32","shape":[2],"data_offsets":)" + second + "}}"),
                      16);
    };
    EXPECT_NO_THROW(read(two("[0,8]", "[8,16]")));
    EXPECT_NO_THROW(read(two("[8,16]", "[0,8]")));
    expect_refused(two("[0,8]", "[4,12]"),
                   "data_offsets of tensor 'b' must be from 8, where the tensor before it ends, "
                   "got [4, 12]");
    expect_refusal([&] { read(two("[0,8]", "[0,8]")); },
                   "must be from 8, where the tensor before it ends, got [0, 8]");
    expect_refused(two("[12,20]", "[0,8]"), "data_offsets of tensor 'a' must be within the 16");
    expect_refused(two("[8,16]", "[4,12]"), "data_offsets of tensor 'b' must be from 0");
}

TEST(TensorFile, RefusesTooManyTensorsAndStrings) {
    const auto header = [](const char* before, std::size_t count, auto entry) {
        std::string text = before;
        for (std::size_t i = 0; i < count; ++i)
            text += (i == 0 ? "\"" : ",\"") + std::to_string(i) + "\":" + entry(i);
        return text;
    };
    const auto tensor = [](std::size_t i) {
        return R"({"dtype":"F16","shape":[],"data_offsets":[)" + std::to_string(2 * i) + ',' +
               std::to_string(2 * i + 2) + "]}";
    };
    const auto string = [](std::size_t) { return "\"\""; };
    EXPECT_EQ(read(forged(padded(header("{", max_tensors, tensor) + "}"), 2 * max_tensors))
                  .tensors()
                  .size(),
              max_tensors);
    expect_refused(forged(header("{", max_tensors + 1, tensor) + "}", 2 * max_tensors + 2),
                   "the tensors must be at most 100000, got more");
    EXPECT_EQ(
        read(forged(header("{\"__metadata__\":{", max_tensors, string) + "}}")).strings().size(),
        max_tensors);
    expect_refused(forged(header("{\"__metadata__\":{", max_tensors + 1, string) + "}}"),
                   "the strings must be at most 100000, got more");
}

TEST(TensorFile, NamesWhatIsMissing) {
    const std::vector<char> bytes = sample_file();
    const TensorFile file = read(bytes);
    expect_refusal([&] { (void)file.text("tolerance"); },
                   "TensorFile: string 'tolerance' must be in the file, got none");
    expect_refusal([&] { (void)file.tensor("curve"); },
                   "TensorFile: tensor 'curve' must be in the file, got none");
    expect_refusal([&] { (void)file.numbers<float>("curve", 1); },
                   "TensorFile: tensor 'curve' must be in the file, got none");
}

TEST(TensorFile, RefusesAnotherTypeOrRank) {
    const std::vector<char> bytes = sample_file();
    const TensorFile file = read(bytes);
    expect_refusal([&] { (void)file.numbers<float>("angle", 1, Infinity::allowed); },
                   "TensorFile: tensor 'angle' must be F32 of rank 1, got F64 of rank 1");
    expect_refusal([&] { (void)file.numbers<float>("coefficient", 2); },
                   "TensorFile: tensor 'coefficient' must be F32 of rank 2, got F32 of rank 3");
    expect_refusal([&] { (void)file.numbers<Half>("one", 0); },
                   "TensorFile: tensor 'one' must be F16 of rank 0, got I32 of rank 0");
}

/// A file with the tensor "a" of 1000 ones, but for `other` at `index`.
template <class Number>
std::vector<char> ones(Number one, std::size_t index, Number other) {
    std::vector<Number> numbers(1000, one);
    numbers[index] = other;
    TensorWriter writer;
    writer.add("a", {numbers.size()}, numbers);
    return writer.finish();
}

template <class Number>
void expect_only_finite(Number one, const std::vector<Number>& finite,
                        const std::vector<Number>& infinities, const std::vector<Number>& nans) {
    for (const std::size_t index : {0u, 1u, 7u, 500u, 999u}) {
        const auto numbers = [&](Number other, Infinity infinity) {
            const std::vector<char> bytes = ones(one, index, other);
            (void)read(bytes).numbers<Number>("a", 1, infinity);
        };
        const std::string at = ", got another number at index " + std::to_string(index);
        const std::string not_finite = "tensor 'a' must be finite" + at,
                          is_nan = "tensor 'a' must be without NaN" + at;
        const auto refused = [&](Number other, Infinity infinity, const std::string& sentence) {
            expect_refusal([&] { numbers(other, infinity); }, sentence.c_str());
        };
        for (const Number number : finite) {
            EXPECT_NO_THROW(numbers(number, Infinity::refused));
            EXPECT_NO_THROW(numbers(number, Infinity::allowed));
        }
        for (const Number number : infinities) {
            refused(number, Infinity::refused, not_finite);
            EXPECT_NO_THROW(numbers(number, Infinity::allowed));
        }
        for (const Number number : nans) {
            refused(number, Infinity::refused, not_finite);
            refused(number, Infinity::allowed, is_nan);
        }
    }
}

TEST(TensorFile, RefusesNumbersThatAreNotFinite) {
    using Float = std::numeric_limits<float>;
    using Double = std::numeric_limits<double>;
    expect_only_finite<float>(1, {Float::max(), Float::lowest(), Float::denorm_min(), -0.f},
                              {infinite, -infinite}, {Float::quiet_NaN(), -Float::quiet_NaN()});
    expect_only_finite<double>(1, {Double::max(), Double::lowest(), Double::denorm_min(), -0.},
                               {Double::infinity(), -Double::infinity()},
                               {Double::quiet_NaN(), -Double::quiet_NaN()});
    expect_only_finite<Half>({0x3c00}, {{0x7bff}, {0xfbff}, {1}, {0x8000}}, {{0x7c00}, {0xfc00}},
                             {{0x7c01}, {0x7fff}, {0xfc01}, {0xffff}});
}

TEST(TensorWriter, RefusesWhatCannotBeRead) {
    const auto refused = [](const auto& call, const char* sentence) {
        TensorWriter writer;
        writer.add("a", {1}, std::vector<float>{1});
        expect_refusal([&] { call(writer); }, sentence);
    };
    const std::vector<float> two{1, 2};
    for (const char* const name : {"a", "__metadata__", "padding_1"})
        refused([&](TensorWriter& writer) { writer.add(name, {2}, two); },
                "TensorWriter: name of a tensor must be new and neither '__metadata__' nor "
                "'padding_...', got '");
    refused([&](TensorWriter& writer) { writer.add("\xff", {2}, two); },
            "TensorWriter: name of a tensor must be UTF-8, got '\\xff'");
    refused([&](TensorWriter& writer) { writer.add("b", {3}, two); },
            "TensorWriter: shape of tensor 'b' must be of 2 numbers, got [3]");
    refused([&](TensorWriter& writer) { writer.add("b", {0}, two.data()); },
            "TensorWriter: shape of tensor 'b' must be at most 8 numbers of at least 1, got [0]");
    refused(
        [&](TensorWriter& writer) {
            writer.add("b", {1, 1, 1, 1, 1, 1, 1, 1, 2}, two);
        },
        "TensorWriter: shape of tensor 'b' must be at most 8 numbers of at least 1, got [1, 1");
    refused([](TensorWriter& writer) { writer.set("b", "\xc3"); },
            "TensorWriter: string 'b' must be UTF-8, got '\\xc3'");
    refused([](TensorWriter& writer) { writer.set("\xc3", "b"); }, "must be UTF-8");
    refused(
        [](TensorWriter& writer) {
            writer.set("b", std::string(max_tensor_header, 'b'));
            (void)writer.finish();
        },
        "TensorWriter: the header must be at most 16777216 bytes, got 16777");
}

TEST(TensorWriter, RefusesMoreThanIsRead) {
    TensorWriter strings, tensors;
    for (std::size_t i = 0; i < max_tensors; ++i) strings.set(std::to_string(i), "");
    // The checksum is one more.
    expect_refusal([&] { (void)strings.finish(); },
                   "TensorWriter: the strings must be at most 100000, got 100001");
    // Each but the first after a padding.
    for (std::size_t i = 0; i <= max_tensors / 2; ++i)
        tensors.add(std::to_string(i), {1}, std::vector<float>{1});
    expect_refusal(
        [&] { (void)tensors.finish(); },
        "TensorWriter: the tensors with their padding must be at most 100000, got 100001");
}

void read_numbers(const TensorFile& file, const std::string& name) {
    const Tensor& tensor = file.tensor(name);
    const std::size_t rank = tensor.shape.size();
    switch (tensor.type) {
        case TensorType::f16: (void)file.numbers<Half>(name, rank); break;
        case TensorType::f32: (void)file.numbers<float>(name, rank); break;
        case TensorType::f64: (void)file.numbers<double>(name, rank, Infinity::allowed); break;
        case TensorType::i32: (void)file.numbers<std::int32_t>(name, rank); break;
    }
}

/// Reads all that `file` holds; false if it is refused.
bool read_everything(const std::vector<char>& file) {
    try {
        const TensorFile tensors = read(file);
        for (const auto& [name, tensor] : tensors.tensors()) read_numbers(tensors, name);
        return true;
    } catch (const std::invalid_argument& error) {
        const std::string sentence = error.what();
        EXPECT_EQ(sentence.rfind("TensorFile: ", 0), 0u) << sentence;
        expect_holds(sentence, {" must be ", ", got "});
        EXPECT_LT(sentence.size(), 300u) << sentence;
        return false;
    }
}

TEST(TensorFile, RefusesOrReadsEveryDamagedFile) {
    const std::vector<char> whole = sample_file();
    std::uint64_t length = 0;
    std::memcpy(&length, whole.data(), sizeof length);
    const std::size_t data_start = sizeof length + static_cast<std::size_t>(length);
    constexpr char letters[] = "{}[]\",:\\0123456789 u";
    std::mt19937 random(1);
    const auto below = [&](std::size_t count) { return random() % count; };
    const auto offset = [](std::size_t at) { return static_cast<std::ptrdiff_t>(at); };
    int refused = 0, accepted = 0;
    for (int i = 0; i < 20000; ++i) {
        std::vector<char> file = whole;
        for (std::size_t changes = 1 + below(2); changes > 0; --changes) {
            const std::size_t at = below(below(4) == 0 ? file.size() : data_start);
            switch (below(6)) {
                case 0: file.resize(at + 1); break;
                case 1: file[std::min(at, file.size() - 1)] = static_cast<char>(random()); break;
                case 2: file.insert(file.end(), 1 + below(100), '\0'); break;
                default:  // another letter of JSON, in place of one or between two
                    if (at + 1 >= file.size()) break;
                    if (below(2) == 0) {
                        file[at] = letters[below(sizeof letters - 1)];
                    } else {
                        file.insert(file.begin() + offset(at), letters[below(sizeof letters - 1)]);
                        if (below(2) == 0) ++file[0];
                    }
            }
        }
        file.shrink_to_fit();
        ++(read_everything(file) ? accepted : refused);
    }
    EXPECT_GT(refused, 2000);
    EXPECT_GT(accepted, 500);
}

TEST(TensorFile, IsIntactUnlessTextsOrNumbersHaveChanged) {
    const std::vector<char> whole = sample_file();
    EXPECT_TRUE(read(whole).is_intact());
    EXPECT_FALSE(read(forged("{}")).is_intact());
    const std::map<std::string, Tensor> tensors = read(whole).tensors();
    for (const auto at : indices(whole)) {
        std::vector<char> file = whole;
        file[at] = static_cast<char>(file[at] ^ 1);
        const bool in_gap = std::ranges::any_of(tensors, [&](const auto& of) {
            const std::size_t begin =
                static_cast<std::size_t>(static_cast<const char*>(of.second.data) - whole.data());
            return of.first.rfind(padding_prefix, 0) == 0 && at >= begin &&
                   at < begin + 2 * of.second.count();
        });
        try {
            const bool is_intact = read(file).is_intact();
            // A digit of the name of what fills a gap is no part of it either.
            if (in_gap || whole[at - 1] == '_')
                EXPECT_TRUE(is_intact) << at;
            else
                EXPECT_FALSE(is_intact) << at;
        } catch (const std::invalid_argument&) {
        }
    }
}

TEST(TensorFile, RefusesEveryTruncatedFile) {
    const std::vector<char> whole = sample_file();
    for (const auto size : indices(whole))
        EXPECT_FALSE(read_everything({whole.begin(), whole.begin() + static_cast<int>(size)}))
            << size;
}

}  // namespace
}  // namespace stratus
