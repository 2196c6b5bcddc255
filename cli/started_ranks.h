// The ranks that mpirun or srun started this program as.
#pragma once

#include <stratus/bake/rank_transport.h>

#include <memory>

namespace stratus {

/// Null where the program was started by itself.
///
/// Errors   std::runtime_error where it is one of several ranks and cannot reach the others.
std::unique_ptr<RankTransport> started_ranks();

/// One thread for each processor, which the ranks of a machine share.
int threads_of_rank(const RankTransport& ranks);

}  // namespace stratus
