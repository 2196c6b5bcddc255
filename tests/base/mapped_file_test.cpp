#include "base/mapped_tensors.h"

#include "refusal.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstdio>
#include <fstream>
#include <stdexcept>
#include <string>
#include <sys/stat.h>
#include <utility>

namespace stratus {
namespace {

/// A path of a test's own.
std::string temporary_path() {
    return ::testing::TempDir() + "stratus_mapped_file_" +
           ::testing::UnitTest::GetInstance()->current_test_info()->name();
}

void write(const std::string& path, const std::string& content) {
    std::ofstream(path, std::ios::binary) << content;
}

std::string content(const MappedFile& file) {
    return {static_cast<const char*>(file.data()), file.bytes()};
}

void expect_unmapped(const std::string& path, const std::string& reason) {
    expect_refusal<std::runtime_error>([&] { MappedFile{path}; }, {path + ": " + reason});
}

TEST(MappedFile, HasTheBytesOfItsFile) {
    const std::string path = temporary_path(), text("a\0b\xff\n", 5);
    write(path, text);
    const MappedFile file(path);
    EXPECT_EQ(content(file), text);
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(file.data()) % 64, 0u);
    std::remove(path.c_str());
    EXPECT_EQ(content(file), text);
}

TEST(MappedFile, HasEveryByteOfALongFile) {
    const std::string path = temporary_path();
    std::string text;
    for (int i = 0; text.size() < 100000; ++i) text += std::to_string(i);
    write(path, text);
    EXPECT_EQ(content(MappedFile(path)), text);
    std::remove(path.c_str());
}

TEST(MappedFile, CanBeMoved) {
    const std::string path = temporary_path();
    write(path, "one");
    MappedFile one(path);
    write(path + ".2", "two");
    MappedFile two(path + ".2");
    const void* const data = one.data();
    MappedFile moved(std::move(one));
    EXPECT_EQ(moved.data(), data);
    EXPECT_EQ(content(moved), "one");
    moved = std::move(two);
    EXPECT_EQ(content(moved), "two");
    std::remove(path.c_str());
    std::remove((path + ".2").c_str());
}

TEST(MappedFile, SaysWhyAFileCannotBeRead) {
    const std::string path = temporary_path();
    expect_unmapped(path, "No such file or directory");
    expect_unmapped(::testing::TempDir(), "is a directory");
    write(path, "");
    expect_unmapped(path, "is empty");
    std::remove(path.c_str());
    ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);  // nobody writes into it
    expect_unmapped(path, "is not a regular file");
    std::remove(path.c_str());
}

}  // namespace
}  // namespace stratus
