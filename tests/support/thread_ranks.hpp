#pragma once

#include <algorithm>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <mutex>
#include <numeric>
#include <span>
#include <stdexcept>
#include <thread>
#include <vector>

#include "gmis/render/ranks.hpp"

namespace gmis_test {

/// Ranks that are threads of one process: bytes go through memory, and all wait for each other.
class ThreadRanks {
 public:
  /// Memory that the ranks share.
  class Team {
   public:
    explicit Team(int count) : count_(count), sent_(static_cast<std::size_t>(count)), sizes_(sent_.size()) {}

   private:
    friend class ThreadRanks;

    /// Returns when all ranks have called it.
    void wait() {
      std::unique_lock lock(mutex_);
      const std::uint64_t turn = turn_;
      if (++waiting_ == count_) {
        waiting_ = 0;
        ++turn_;
        all_here_.notify_all();
      } else {
        all_here_.wait(lock, [&] { return turn_ != turn; });
      }
    }

    int count_, waiting_ = 0;
    std::uint64_t turn_ = 0;
    std::mutex mutex_;
    std::condition_variable all_here_;
    std::vector<std::span<const std::byte>> sent_;
    std::vector<std::span<const std::size_t>> sizes_;
  };

  ThreadRanks(Team& team, int rank) : team_(team), rank_(static_cast<std::size_t>(rank)) {}

  [[nodiscard]] int rank() const { return static_cast<int>(rank_); }
  [[nodiscard]] int count() const { return team_.count_; }

  void exchange(std::span<const std::byte> send, std::span<const std::size_t> send_sizes, std::span<std::byte> receive,
                std::span<const std::size_t> receive_sizes) {
    team_.sent_[rank_] = send;
    team_.sizes_[rank_] = send_sizes;
    team_.wait();
    std::size_t to = 0;
    for (std::size_t r = 0; r < team_.sent_.size(); ++r) {
      const auto sizes = team_.sizes_[r];
      const std::size_t from = std::accumulate(sizes.begin(), sizes.begin() + static_cast<long>(rank_), std::size_t{0});
      if (sizes[rank_] != receive_sizes[r]) throw std::logic_error("ranks disagree about the size of a part");
      const auto part = team_.sent_[r].subspan(from, sizes[rank_]);
      std::copy(part.begin(), part.end(), receive.subspan(to, part.size()).begin());
      to += part.size();
    }
    team_.wait();
  }
  void gather(std::span<const std::byte> send, std::span<std::byte> receive, std::span<const std::size_t>) {
    team_.sent_[rank_] = send;
    team_.wait();
    if (rank_ == 0) {
      std::size_t to = 0;
      for (const auto part : team_.sent_) {
        std::copy(part.begin(), part.end(), receive.subspan(to, part.size()).begin());
        to += part.size();
      }
    }
    team_.wait();
  }
  void broadcast(std::span<std::byte> bytes) {
    team_.sent_[rank_] = bytes;
    team_.wait();
    if (rank_ > 0) std::copy(team_.sent_[0].begin(), team_.sent_[0].end(), bytes.begin());
    team_.wait();
  }

 private:
  Team& team_;
  std::size_t rank_;
};

static_assert(gmis::Ranks<ThreadRanks>);

/// Calls `work(ranks)` on this number of ranks, each a thread, and throws what rank 0 has thrown.
/// All ranks must throw or none.
template <class Work>
void on_ranks(int count, Work&& work) {
  ThreadRanks::Team team(count);
  std::exception_ptr failure;
  const auto serve = [&](int rank) {
    ThreadRanks ranks(team, rank);
    try {
      work(gmis::RanksRef(ranks));
    } catch (...) {
      if (rank == 0) failure = std::current_exception();
    }
  };
  std::vector<std::thread> threads;
  for (int rank = 1; rank < count; ++rank) threads.emplace_back(serve, rank);
  serve(0);
  for (std::thread& thread : threads) thread.join();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace gmis_test
