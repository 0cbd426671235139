#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "gmis/core/argument_error.hpp"
#include "gmis/core/attributes.hpp"
#include "gmis/core/state_archive.hpp"
#include "gmis/render/run_identity.hpp"

/// \file
/// The bytes of a checkpoint: the format, whose run it is, then the state with its length and
/// digest.

namespace gmis {

/// A checkpoint whose state is whole.
struct Checkpoint {
  RunIdentity identity;              ///< of the run that it was taken from
  std::span<const std::byte> state;  ///< refers to the bytes that were read
};

namespace detail {

/// Changes with every change of the state's layout.
inline constexpr std::string_view checkpoint_format = "gmis checkpoint 6\n";

/// The bytes of a checkpoint with this state.
GMIS_RARE [[nodiscard]] inline std::vector<std::byte> checkpoint_bytes(RunIdentity identity,
                                                                       const std::vector<std::byte>& state) {
  std::string format{checkpoint_format};
  std::uint64_t digest = digest_of(state), size = state.size();
  StateWriter whole;
  whole(format, identity, digest, size);
  std::vector<std::byte> result = whole.bytes();
  result.insert(result.end(), state.begin(), state.end());
  return result;
}

}  // namespace detail

/// Reads the bytes of a checkpoint, which must outlive the result. `expected`: the run that it must
/// be of, apart from the properties in `may_differ`. Throws `std::invalid_argument` that says what
/// differs, or that the bytes are damaged.
GMIS_RARE [[nodiscard]] inline Checkpoint open_checkpoint(std::span<const std::byte> bytes, const RunIdentity& expected,
                                                          std::span<const std::string_view> may_differ = {}) {
  const auto refuse = [](const std::string& message) { reject_argument(message.c_str()); };
  StateReader header(bytes);
  std::string format;
  std::uint64_t digest = 0, size = 0;
  Checkpoint checkpoint;
  header(format);
  if (header.is_broken() || format != detail::checkpoint_format) refuse("this is no checkpoint of this version");
  header(checkpoint.identity, digest, size);
  if (header.is_broken()) refuse("the checkpoint is cut short");
  if (const std::string difference = checkpoint.identity.difference_to(expected, may_differ); !difference.empty())
    refuse("the checkpoint is of another run: " + difference);
  checkpoint.state = header.left();
  if (size != checkpoint.state.size()) refuse("the checkpoint is cut short or longer than it says");
  if (digest != digest_of(checkpoint.state)) refuse("the checkpoint is damaged: its digest differs");
  return checkpoint;
}

}  // namespace gmis
