#include <stratus/io/file_bytes.h>

#include <stratus/io/table_file.h>

#include "refusal.h"
#include "sample_table.h"
#include "temporary_folder.h"

#include <gtest/gtest.h>

#include <cerrno>
#include <csignal>
#include <fstream>
#include <stdexcept>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <system_error>
#include <unistd.h>

namespace {

bool grants_locks = true;

}  // namespace

/// In place of the C library's, as on a file system that never grants a lock.
extern "C" int flock(int file, int operation) noexcept {
    if (grants_locks) return static_cast<int>(::syscall(SYS_flock, file, operation));
    errno = EWOULDBLOCK;
    return -1;
}

namespace stratus::test {
namespace {

namespace fs = std::filesystem;

void write_new(const fs::path& path) { set_content(path, "new"); }

std::string refusal_of_writing(const fs::path& path) {
    return refusal<std::runtime_error>([&] { write_atomically(path, write_new); });
}

TEST(AtomicFile, TakesItsPlaceBeforeItIsFlushed) {
    const TemporaryFolder folder;
    for (const char* name : {"a.txt", "b.txt"})
        write_atomically(folder / name, write_new, Flush::later);
    EXPECT_EQ(content(folder / "a.txt"), "new");
    EXPECT_EQ(folder.size(), 2U);
    flush_files({folder / "a.txt", folder / "b.txt"});
    EXPECT_EQ(content(folder / "b.txt"), "new");
}

TEST(AtomicFile, NamesAFileToFlushThatIsNotThere) {
    EXPECT_NO_THROW(flush_files({}));
    const TemporaryFolder folder;
    set_content(folder / "a.txt", "new");
    const fs::path missing = folder / "b.txt";
    EXPECT_EQ(refusal<std::runtime_error>([&] {
                  flush_files({folder / "a.txt", missing});
              }),
              missing.string() + ": No such file or directory");
}

TEST(AtomicFile, IsWrittenInTheSameFolderWithTheSameExtension) {
    const TemporaryFolder folder;
    write_atomically(folder / "a.h5", [&](const fs::path& temporary) {
        EXPECT_EQ(temporary.parent_path(), folder.path());
        EXPECT_EQ(temporary.extension(), ".h5");
        EXPECT_FALSE(fs::exists(folder / "a.h5"));
        write_new(temporary);
    });
    EXPECT_EQ(content(folder / "a.h5"), "new");
    EXPECT_EQ(folder.size(), 1U);
}

TEST(AtomicFile, KeepsTheOlderFileWhenWritingThrows) {
    const TemporaryFolder folder;
    set_content(folder / "a.txt", "old");
    const auto write = [](const fs::path& temporary) {
        write_new(temporary);
        throw std::logic_error("stop");
    };
    EXPECT_EQ(refusal<std::logic_error>([&] { write_atomically(folder / "a.txt", write); }),
              "stop");
    EXPECT_EQ(content(folder / "a.txt"), "old");
    EXPECT_EQ(folder.size(), 1U);
}

TEST(AtomicFile, NamesThePathInSystemErrors) {
    const TemporaryFolder folder;
    const auto write = [](const fs::path&) {
        throw std::system_error(ENOSPC, std::generic_category());
    };
    EXPECT_EQ(refusal<std::runtime_error>([&] { write_atomically(folder / "a.txt", write); }),
              (folder / "a.txt").string() + ": No space left on device");
    EXPECT_EQ(folder.size(), 0U);
}

TEST(AtomicFile, RefusesPathsThatCannotBeFiles) {
    const TemporaryFolder folder;
    set_content(folder / "file", "old");
    fs::create_symlink("link.txt", folder / "link.txt");
    for (const auto& [path, reason] :
         {std::pair{folder / "missing" / "a.txt", "No such file or directory"},
          {folder / "file" / "a.txt", "Not a directory"},
          {folder / "link.txt", "Too many levels of symbolic links"},
          {"/dev/null", "is not a regular file"},
          {"", "a file name is needed"}})
        EXPECT_EQ(refusal_of_writing(path), path.string() + ": " + reason);
}

TEST(AtomicFile, RefusesADirectoryBeforeWriting) {
    const TemporaryFolder folder;
    const auto write = [](const fs::path&) { FAIL() << "must not be called"; };
    EXPECT_EQ(refusal<std::runtime_error>([&] { write_atomically(folder.path(), write); }),
              folder.path().string() + ": is a directory");
}

TEST(AtomicFile, RefusesAReadOnlyFolder) {
    const TemporaryFolder folder;
    fs::permissions(folder.path(), fs::perms::owner_read | fs::perms::owner_exec);
    if (std::ofstream(folder / "probe")) GTEST_SKIP() << "this user may write anywhere";
    const fs::path path = folder / "a.txt";
    const std::string message = refusal_of_writing(path);
    fs::permissions(folder.path(), fs::perms::owner_all);
    EXPECT_EQ(message, path.string() + ": Permission denied");
}

TEST(AtomicFile, KeepsASymbolicLinkAndReplacesItsTarget) {
    const TemporaryFolder folder;
    fs::create_directory(folder / "elsewhere");
    set_content(folder / "elsewhere" / "a.txt", "old");
    fs::create_symlink("elsewhere/a.txt", folder / "link.txt");
    write_atomically(folder / "link.txt", write_new);
    EXPECT_TRUE(fs::is_symlink(folder / "link.txt"));
    EXPECT_EQ(content(folder / "elsewhere" / "a.txt"), "new");
}

TEST(AtomicFile, MakesTheTargetOfADanglingLink) {
    const TemporaryFolder folder;
    fs::create_directory(folder / "elsewhere");
    fs::create_symlink("elsewhere/b.txt", folder / "first.txt");
    fs::create_symlink("first.txt", folder / "link.txt");
    write_atomically(folder / "link.txt", write_new);
    EXPECT_TRUE(fs::is_symlink(folder / "link.txt"));
    EXPECT_TRUE(fs::is_symlink(folder / "first.txt"));
    EXPECT_EQ(content(folder / "elsewhere" / "b.txt"), "new");
}

TEST(AtomicFile, RefusesToReplaceAnOpenFile) {
    if (!fs::is_symlink("/dev/stdout")) GTEST_SKIP() << "no /dev/stdout here";
    EXPECT_EQ(refusal_of_writing("/dev/stdout"),
              "/dev/stdout: names an open file, which cannot be replaced");
}

TEST(WriteContent, SaysThatTheDiskIsFull) {
    if (!fs::is_character_file("/dev/full")) GTEST_SKIP() << "no /dev/full here";
    const TemporaryFolder folder;
    const auto write = [](const fs::path&) { write_content("/dev/full", "new"); };
    EXPECT_EQ(refusal<std::runtime_error>([&] { write_atomically(folder / "a.txt", write); }),
              (folder / "a.txt").string() + ": No space left on device");
}

/// The hidden file left by a writer that is killed while writing to `path`.
fs::path abandoned_by_a_killed_writer(const fs::path& path) {
    const pid_t child = ::fork();
    if (child == 0)
        write_atomically(path, [](const fs::path& temporary) {
            set_content(temporary, "half");
            ::raise(SIGKILL);
        });
    int status = 0;
    ::waitpid(child, &status, 0);
    EXPECT_TRUE(WIFSIGNALED(status));
    for (const auto& entry : fs::directory_iterator(path.parent_path()))
        if (entry.path().filename().string().starts_with('.' + path.stem().string() + '.'))
            return entry.path();
    ADD_FAILURE() << "nothing was left behind";
    return {};
}

TEST(AtomicFile, RemovesHiddenFilesOfKilledWriters) {
    const TemporaryFolder folder;
    set_content(folder / "a.txt", "old");
    const fs::path first = abandoned_by_a_killed_writer(folder / "a.txt");
    abandoned_by_a_killed_writer(folder / "a.txt");
    EXPECT_FALSE(fs::exists(first));
    const fs::path of_another = abandoned_by_a_killed_writer(folder / "b.txt");
    ASSERT_EQ(folder.size(), 3U);
    EXPECT_EQ(content(folder / "a.txt"), "old");
    write_atomically(folder / "a.txt", write_new);
    EXPECT_EQ(content(folder / "a.txt"), "new");
    EXPECT_TRUE(fs::exists(of_another));
    EXPECT_EQ(folder.size(), 2U);
}

TEST(AtomicFile, KeepsHiddenFilesOfLivingWriters) {
    const TemporaryFolder folder;
    write_atomically(folder / "a.txt", [&](const fs::path& temporary) {
        write_atomically(folder / "a.txt",
                         [](const fs::path& other) { set_content(other, "first"); });
        EXPECT_EQ(content(folder / "a.txt"), "first");
        set_content(temporary, "second");
    });
    EXPECT_EQ(content(folder / "a.txt"), "second");
    EXPECT_EQ(folder.size(), 1U);
}

TEST(AtomicFile, KeepsFilesWithSimilarNames) {
    const TemporaryFolder folder;
    set_content(folder / ".a.txt", "");
    set_content(folder / ".a.mine.partial.txt", "");
    set_content(folder / ".a.12-0-ff.partial.csv", "");
    write_atomically(folder / "a.txt", write_new);
    EXPECT_EQ(folder.size(), 4U);
}

TEST(AtomicFile, GivesUpWhereNoLockIsEverGranted) {
    const TemporaryFolder folder;
    grants_locks = false;
    const std::string message = refusal_of_writing(folder / "a.txt");
    grants_locks = true;
    EXPECT_EQ(message, (folder / "a.txt").string() + ": No locks available");
    EXPECT_EQ(folder.size(), 0U);
}

TEST(AtomicFile, AcceptsAPathWithoutAFolder) {
    const TemporaryFolder folder;
    const fs::path before = fs::current_path();
    fs::current_path(folder.path());
    write_atomically("a.txt", write_new);
    fs::current_path(before);
    EXPECT_EQ(content(folder / "a.txt"), "new");
}

class FullDisk : public testing::TestWithParam<const char*> {};

TEST_P(FullDisk, LeavesOnlyTheOlderTable) {
    const TemporaryFolder folder;
    const fs::path path = folder / GetParam();
    Table table = sample_table();
    write_table(table, path);
    const std::string before = content(path);

    table.tolerance = 0.5;
    std::string message;
    {
        const FileSizeLimit limit(1000);
        message = refusal<std::runtime_error>([&] { write_table(table, path); });
    }
    EXPECT_EQ(message, path.string() + ": File too large");
    EXPECT_EQ(content(path), before);
    EXPECT_EQ(folder.size(), 1U);
}

INSTANTIATE_TEST_SUITE_P(Formats, FullDisk, testing::Values("table.h5", "table.exr"),
                         [](const auto& row) {
                             return fs::path(row.param).extension().string().substr(1);
                         });

}  // namespace
}  // namespace stratus::test
