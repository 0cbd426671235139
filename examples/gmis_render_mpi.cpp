// gmis-render-mpi: gmis-render over MPI. docs/many-machines.md tells how it is used.

#include <mpi.h>

#include <algorithm>
#include <climits>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <stdexcept>
#include <vector>

#include "gmis/render/ranks.hpp"
#include "support/render_program.hpp"

namespace {

/// The processes of an MPI job. Sizes of MPI are `int`: what is larger goes in pieces, or is
/// refused.
class MpiRanks {
 public:
  MpiRanks() {
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &count_);
  }

  [[nodiscard]] int rank() const { return rank_; }
  [[nodiscard]] int count() const { return count_; }

  void exchange(std::span<const std::byte> send, std::span<const std::size_t> send_sizes, std::span<std::byte> receive,
                std::span<const std::size_t> receive_sizes) {
    const Layout from(send_sizes), to(receive_sizes);
    if (is_measuring_) {
      const double start = MPI_Wtime();
      MPI_Barrier(MPI_COMM_WORLD);
      waiting_ += MPI_Wtime() - start;
    }
    const Measured measured(*this, exchanges_, receive.size());
    MPI_Alltoallv(send.data(), from.sizes.data(), from.places.data(), MPI_BYTE, receive.data(), to.sizes.data(),
                  to.places.data(), MPI_BYTE, MPI_COMM_WORLD);
  }
  void gather(std::span<const std::byte> send, std::span<std::byte> receive, std::span<const std::size_t> sizes) {
    const Measured measured(*this, gathers_, receive.size());
    if (rank_ > 0) {
      in_pieces(send, [](std::span<const std::byte> piece) {
        MPI_Send(piece.data(), static_cast<int>(piece.size()), MPI_BYTE, 0, 0, MPI_COMM_WORLD);
      });
      return;
    }
    std::copy(send.begin(), send.end(), receive.begin());
    std::size_t at = sizes[0];
    for (int rank = 1; rank < count_; at += sizes[static_cast<std::size_t>(rank)], ++rank)
      in_pieces(receive.subspan(at, sizes[static_cast<std::size_t>(rank)]), [rank](std::span<std::byte> piece) {
        MPI_Recv(piece.data(), static_cast<int>(piece.size()), MPI_BYTE, rank, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
      });
  }
  static void broadcast(std::span<std::byte> bytes) {
    in_pieces(bytes, [](std::span<std::byte> piece) {
      MPI_Bcast(piece.data(), static_cast<int>(piece.size()), MPI_BYTE, 0, MPI_COMM_WORLD);
    });
  }

  /// With GMIS_MPI_TIMES set: one line of JSON on standard error, with the bytes that rank 0
  /// received and the seconds this took.
  void print_times() const {
    if (is_measuring_ && rank_ == 0)
      std::fprintf(stderr,
                   "{\"ranks\": %d, \"waiting\": %.6f, \"exchanges\": %.0f, \"exchange_bytes\": %.0f, "
                   "\"exchange_seconds\": %.6f, \"gathers\": %.0f, \"gather_bytes\": %.0f, \"gather_seconds\": %.6f}\n",
                   count_, waiting_, exchanges_.calls, exchanges_.bytes, exchanges_.seconds, gathers_.calls,
                   gathers_.bytes, gathers_.seconds);
  }

 private:
  struct Traffic {
    double calls = 0, bytes = 0, seconds = 0;
  };
  /// Adds the time of its lifetime.
  class Measured {
   public:
    Measured(const MpiRanks& ranks, Traffic& traffic, std::size_t bytes) : traffic_(traffic), start_(MPI_Wtime()) {
      if (!ranks.is_measuring_) return;
      traffic.calls += 1;
      traffic.bytes += static_cast<double>(bytes);
    }
    ~Measured() { traffic_.seconds += MPI_Wtime() - start_; }
    Measured(const Measured&) = delete;
    Measured& operator=(const Measured&) = delete;

   private:
    Traffic& traffic_;
    double start_;
  };
  struct Layout {
    std::vector<int> sizes, places;

    explicit Layout(std::span<const std::size_t> of) {
      std::size_t place = 0;
      for (const std::size_t size : of) {
        places.push_back(static_cast<int>(place));
        sizes.push_back(static_cast<int>(size));
        place += size;
      }
      if (place > INT_MAX) throw std::runtime_error("the frames of a round exceed 2 GiB: choose a smaller --size");
    }
  };

  template <class Bytes, class Use>
  static void in_pieces(Bytes bytes, Use&& use) {
    constexpr std::size_t most = std::size_t{1} << 30U;
    for (; bytes.size() > most; bytes = bytes.subspan(most)) use(bytes.first(most));
    use(bytes);
  }

  int rank_ = 0, count_ = 1;
  const bool is_measuring_ = std::getenv("GMIS_MPI_TIMES") != nullptr;
  double waiting_ = 0.0;
  Traffic exchanges_, gathers_;
};

}  // namespace

int main(int argc, char** argv) {
  int given = 0;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &given);
  MpiRanks ranks;
  const int code = gmis::tools::render_program(argc, argv, ranks);
  ranks.print_times();
  // Other ranks may wait for one that has failed. A wrong request fails on all of them, and rank 0
  // says so.
  if (code == 1 || (code != 0 && ranks.rank() == 0)) MPI_Abort(MPI_COMM_WORLD, code);
  MPI_Finalize();
  return code;
}
