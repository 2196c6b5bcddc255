// Ranks by MPI. Calls of MPI are made one at a time, under a mutex, and none of them waits: MPI
// libraries keep a processor busy while they do, and here ranks may have more threads than cores.
#include <stratus/bake/ranks.h>

#include <mpi.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <limits>
#include <mutex>
#include <stdexcept>
#include <string>

namespace stratus {
namespace {

constexpr std::chrono::microseconds longest_sleep{200};

/// Longer messages go in parts, and no further than while one looks after them.
constexpr std::size_t most_in_one_go = std::size_t{1} << 12;

/// MPI counts in int.
constexpr std::size_t most_at_once = std::size_t{1} << 28;

class MpiTransport : public RankTransport {
  public:
    MpiTransport() {
        int given = MPI_THREAD_SINGLE;
        MPI_Init_thread(nullptr, nullptr, MPI_THREAD_SERIALIZED, &given);
        if (given < MPI_THREAD_SERIALIZED)
            throw std::runtime_error("this MPI library does not serve several threads");
        MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
        MPI_Comm_size(MPI_COMM_WORLD, &count_);
        MPI_Comm machine = MPI_COMM_NULL;
        MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, rank_, MPI_INFO_NULL, &machine);
        MPI_Comm_size(machine, &count_on_this_machine_);
        MPI_Comm_free(&machine);
    }
    ~MpiTransport() override { MPI_Finalize(); }

    int rank() const override { return rank_; }
    int count() const override { return count_; }
    int count_on_this_machine() const override { return count_on_this_machine_; }

    void send(int to, int tag, std::span<const char> bytes) override {
        if (bytes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max()))
            throw std::runtime_error("a message of " + std::to_string(bytes.size()) +
                                     " bytes is too long for MPI");
        await(bytes.size(), [&] {
            MPI_Request request = MPI_REQUEST_NULL;
            MPI_Isend(bytes.data(), static_cast<int>(bytes.size()), MPI_CHAR, to, tag,
                      MPI_COMM_WORLD, &request);
            return request;
        });
    }

    std::optional<RankMessage> receive(int from, int tag) override {
        int has_come = 0;
        MPI_Message message = MPI_MESSAGE_NULL;
        MPI_Status status;
        RankMessage received{from, {}};
        {
            const std::lock_guard lock(mutex_);
            MPI_Improbe(from < 0 ? MPI_ANY_SOURCE : from, tag, MPI_COMM_WORLD, &has_come, &message,
                        &status);
            if (has_come == 0) return std::nullopt;
            int size = 0;
            MPI_Get_count(&status, MPI_CHAR, &size);
            received.from = status.MPI_SOURCE;
            received.bytes.resize(static_cast<std::size_t>(size));
        }
        await(received.bytes.size(), [&] {
            MPI_Request request = MPI_REQUEST_NULL;
            MPI_Imrecv(received.bytes.data(), static_cast<int>(received.bytes.size()), MPI_CHAR,
                       &message, &request);
            return request;
        });
        return received;
    }

    void broadcast(std::span<char> bytes) override {
        for (std::size_t first = 0; first < bytes.size(); first += most_at_once) {
            const std::span<char> some =
                bytes.subspan(first, std::min(most_at_once, bytes.size() - first));
            await(some.size(), [&] {
                MPI_Request request = MPI_REQUEST_NULL;
                MPI_Ibcast(some.data(), static_cast<int>(some.size()), MPI_CHAR, 0, MPI_COMM_WORLD,
                           &request);
                return request;
            });
        }
    }

    [[noreturn]] void abort(int exit_code) override {
        MPI_Abort(MPI_COMM_WORLD, exit_code);
        std::_Exit(exit_code);
    }

  private:
    /// Waits for what begin() has begun, with so many bytes.
    template <class Begin>
    void await(std::size_t bytes, const Begin& begin) {
        MPI_Request request = MPI_REQUEST_NULL;
        {
            const std::lock_guard lock(mutex_);
            request = begin();
        }
        for (Backoff backoff(bytes > most_in_one_go ? Backoff::shortest : longest_sleep);;
             backoff.sleep()) {
            {
                const std::lock_guard lock(mutex_);
                int is_done = 0;
                MPI_Test(&request, &is_done, MPI_STATUS_IGNORE);
                if (is_done != 0) return;
            }
        }
    }

    std::mutex mutex_;
    int rank_ = 0, count_ = 1, count_on_this_machine_ = 1;
};

}  // namespace
}  // namespace stratus

extern "C" __attribute__((visibility("default"))) stratus::RankTransport* stratus_start_ranks() {
    return new stratus::MpiTransport();
}
