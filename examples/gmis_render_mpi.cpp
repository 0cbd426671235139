// gmis-render-mpi: gmis-render over MPI. docs/many-machines.md tells how it is used.

#include <mpi.h>

#include <algorithm>
#include <climits>
#include <cstddef>
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

  static void exchange(std::span<const std::byte> send, std::span<const std::size_t> send_sizes,
                       std::span<std::byte> receive, std::span<const std::size_t> receive_sizes) {
    const Layout from(send_sizes), to(receive_sizes);
    MPI_Alltoallv(send.data(), from.sizes.data(), from.places.data(), MPI_BYTE, receive.data(), to.sizes.data(),
                  to.places.data(), MPI_BYTE, MPI_COMM_WORLD);
  }
  void gather(std::span<const std::byte> send, std::span<std::byte> receive, std::span<const std::size_t> sizes) const {
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

 private:
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
};

}  // namespace

int main(int argc, char** argv) {
  int given = 0;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &given);
  MpiRanks ranks;
  const int code = gmis::tools::render_program(argc, argv, ranks);
  // Other ranks may wait for one that has failed. A wrong request fails on all of them, and rank 0
  // says so.
  if (code == 1 || (code != 0 && ranks.rank() == 0)) MPI_Abort(MPI_COMM_WORLD, code);
  MPI_Finalize();
  return code;
}
