#include <stratus/io/checkpoint.h>

#include "indices.h"
#include "refusal.h"
#include "temporary_folder.h"

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace stratus::test {
namespace {

namespace fs = std::filesystem;

const CheckpointOwner owner{"stratus 1", "title = 'a'\nalbedo = 0.5\n"};

std::span<const char> bytes(const std::string& text) { return {text.data(), text.size()}; }

std::string found(const Checkpoint& checkpoint, const std::string& piece) {
    const auto result = checkpoint.find(piece);
    return result ? std::string(result->begin(), result->end()) : "not there";
}

void expect_results_or_nothing(const Checkpoint& checkpoint) {
    for (const std::string piece : {"one", "two", "three"}) {
        const std::string result = found(checkpoint, piece);
        EXPECT_TRUE(result == "result of " + piece || result == "not there") << result;
    }
}

class CheckpointFile : public testing::Test {
  protected:
    void keep_three_pieces() const {
        Checkpoint checkpoint(path, owner);
        for (const char* piece : {"one", "two", "three"})
            checkpoint.keep(piece, bytes("result of " + std::string(piece)));
    }

    std::string refusal_for(const CheckpointOwner& of) const {
        const std::string before = content(path);
        const std::string message =
            refusal<std::runtime_error>([&] { Checkpoint checkpoint(path, of); });
        EXPECT_EQ(content(path), before);
        return message;
    }

    TemporaryFolder folder;
    const fs::path path = folder / "table.h5.checkpoint";
};

TEST_F(CheckpointFile, ReturnsKeptPieces) {
    keep_three_pieces();
    const Checkpoint checkpoint(path, owner);
    EXPECT_EQ(checkpoint.pieces(), 3U);
    EXPECT_EQ(found(checkpoint, "one"), "result of one");
    EXPECT_EQ(found(checkpoint, "three"), "result of three");
    EXPECT_EQ(found(checkpoint, "four"), "not there");
    EXPECT_EQ(found(checkpoint, "recipe"), "not there");
}

TEST_F(CheckpointFile, AppendsToExistingPieces) {
    keep_three_pieces();
    Checkpoint(path, owner).keep("four", bytes(""));
    const Checkpoint checkpoint(path, owner);
    EXPECT_EQ(checkpoint.pieces(), 4U);
    EXPECT_EQ(found(checkpoint, "two"), "result of two");
    EXPECT_EQ(found(checkpoint, "four"), "");
}

TEST_F(CheckpointFile, KeepsPiecesFromManyThreads) {
    {
        Checkpoint checkpoint(path, owner);
        std::vector<std::thread> threads;
        for (unsigned t = 0; t < 4; ++t)
            threads.emplace_back([&checkpoint, t] {
                for (unsigned n = 0; n < 50; ++n)
                    checkpoint.keep(std::to_string(50 * t + n), bytes(std::string(n, 'x')));
            });
        for (std::thread& thread : threads) thread.join();
    }
    const Checkpoint checkpoint(path, owner);
    EXPECT_EQ(checkpoint.pieces(), 200U);
    for (unsigned n = 0; n < 200; ++n)
        EXPECT_EQ(found(checkpoint, std::to_string(n)), std::string(n % 50, 'x'));
}

TEST_F(CheckpointFile, DropsTruncatedPieces) {
    keep_three_pieces();
    const std::string whole = content(path);
    std::size_t pieces = 0;
    for (std::size_t length = 0; length <= whole.size(); ++length) {
        set_content(path, whole.substr(0, length));
        {
            Checkpoint checkpoint(path, owner);
            pieces = checkpoint.pieces();
            EXPECT_LE(pieces, 3U * length / whole.size()) << length;
            expect_results_or_nothing(checkpoint);
            checkpoint.keep("next", bytes("more"));
        }
        const Checkpoint checkpoint(path, owner);
        EXPECT_EQ(checkpoint.pieces(), pieces + 1) << length;
        EXPECT_EQ(found(checkpoint, "next"), "more") << length;
    }
    EXPECT_EQ(pieces, 3U);
}

TEST_F(CheckpointFile, NeverReturnsDamagedPieces) {
    keep_three_pieces();
    const std::string whole = content(path);
    for (const auto at : indices(whole)) {
        std::string damaged = whole;
        damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
        set_content(path, damaged);
        try {
            const Checkpoint checkpoint(path, owner);
            EXPECT_LT(checkpoint.pieces(), 3U) << at;
            expect_results_or_nothing(checkpoint);
        } catch (const std::runtime_error&) {  // in the first line
            EXPECT_LT(at, 21U);
        }
    }
}

TEST_F(CheckpointFile, IsRefusedForAnotherRecipeNamingTheFirstDifference) {
    keep_three_pieces();
    EXPECT_EQ(
        refusal_for({owner.program, "title = 'a'\nalbedo = 0.25\n"}),
        path.string() +
            ": belongs to another recipe, with \"albedo = 0.5\" where this one has \"albedo = "
            "0.25\"; remove it to start over");
    EXPECT_EQ(
        refusal_for({owner.program, owner.recipe + "orders = 3\n"}),
        path.string() +
            ": belongs to another recipe, with \"\" where this one has \"orders = 3\"; remove it "
            "to start over");
}

TEST_F(CheckpointFile, IsRefusedForAnotherProgram) {
    keep_three_pieces();
    EXPECT_EQ(
        refusal_for({"stratus 2", owner.recipe}),
        path.string() +
            ": belongs to another program, with \"stratus 1\" where this one has \"stratus 2\"; "
            "remove it to start over");
}

TEST_F(CheckpointFile, RefusesFilesThatAreNotCheckpoints) {
    set_content(path, "dear diary\n");
    EXPECT_EQ(refusal_for(owner), path.string() + ": is not a checkpoint");
    set_content(path, "stratus-checkpoint 2\nnews");
    EXPECT_EQ(refusal_for(owner), path.string() + ": is a checkpoint of another version");
}

TEST_F(CheckpointFile, RefusesADirectory) {
    fs::create_directory(path);
    EXPECT_EQ(refusal<std::runtime_error>([&] { Checkpoint checkpoint(path, owner); }),
              path.string() + ": Is a directory");
}

TEST_F(CheckpointFile, IsLocked) {
    Checkpoint first(path, owner);
    first.keep("one", bytes("result of one"));
    EXPECT_EQ(refusal_for(owner), path.string() + ": another bake of this table is running");
}

TEST_F(CheckpointFile, WaitsForALockThatIsReleasedSoon) {
    auto first = std::make_unique<Checkpoint>(path, owner);
    first->keep("one", bytes("result of one"));
    std::thread ending([&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(120));
        first.reset();
    });
    EXPECT_EQ(found(Checkpoint(path, owner), "one"), "result of one");
    ending.join();
}

TEST_F(CheckpointFile, IsRemovedWhenDoneOrEmpty) {
    { const Checkpoint checkpoint(path, owner); }
    EXPECT_EQ(folder.size(), 0U);
    {
        Checkpoint checkpoint(path, owner);
        checkpoint.keep("one", bytes("result of one"));
        checkpoint.remove();
    }
    EXPECT_EQ(folder.size(), 0U);
}

TEST_F(CheckpointFile, RemovesOnlyItsOwnFile) {
    Checkpoint checkpoint(path, owner);
    fs::remove(path);
    set_content(path, "of another");
    checkpoint.remove();
    EXPECT_EQ(content(path), "of another");
}

TEST_F(CheckpointFile, IsEmptiedWhenTheDiskIsFull) {
    keep_three_pieces();
    {
        Checkpoint checkpoint(path, owner);
        {
            const FileSizeLimit limit(4096);
            checkpoint.keep("large", bytes(std::string(10000, 'x')));
        }
        EXPECT_EQ(checkpoint.trouble(), path.string() + ": File too large");
        EXPECT_EQ(fs::file_size(path), 0U);
        EXPECT_EQ(checkpoint.pieces(), 0U);
        EXPECT_EQ(found(checkpoint, "one"), "not there");
        checkpoint.keep("small", bytes("x"));
        EXPECT_EQ(fs::file_size(path), 0U);
    }
    EXPECT_EQ(folder.size(), 0U);
}

}  // namespace
}  // namespace stratus::test
