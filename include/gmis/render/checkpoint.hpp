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
inline constexpr std::string_view checkpoint_format = "gmis checkpoint 8\n";

/// The bytes of a checkpoint with this state.
GMIS_RARE [[nodiscard]] inline std::vector<std::byte> checkpoint_bytes(RunIdentity identity,
                                                                       const std::vector<std::byte>& state) {
  StateWriter header, start;
  header(identity);
  std::vector<std::byte> body = header.bytes();
  body.insert(body.end(), state.begin(), state.end());
  std::string format{checkpoint_format};
  std::uint64_t digest = digest_of(body), size = body.size();
  start(format, digest, size);
  std::vector<std::byte> result = start.bytes();
  result.insert(result.end(), body.begin(), body.end());
  return result;
}

}  // namespace detail

/// Reads the bytes of a checkpoint, which must outlive the result. `expected`: the run that it must
/// be of, apart from the properties in `may_differ`. Throws `std::invalid_argument` that says what
/// differs, or that the bytes are damaged.
GMIS_RARE [[nodiscard]] inline Checkpoint open_checkpoint(std::span<const std::byte> bytes, const RunIdentity& expected,
                                                          std::span<const std::string_view> may_differ = {}) {
  const auto refuse = [](const std::string& message) { reject_argument(message.c_str()); };
  StateReader start(bytes);
  std::string format;
  std::uint64_t digest = 0, size = 0;
  start(format);
  if (start.is_broken() || format != detail::checkpoint_format) refuse("this is no checkpoint of this version");
  start(digest, size);
  if (start.is_broken()) refuse("the checkpoint is cut short");
  // First of all, so that no message quotes damaged bytes.
  if (size != start.left().size()) refuse("the checkpoint is cut short or longer than it says");
  if (digest != digest_of(start.left())) refuse("the checkpoint is damaged: its digest differs");
  StateReader body(start.left());
  Checkpoint checkpoint;
  body(checkpoint.identity);
  if (body.is_broken()) refuse("the checkpoint is damaged");
  if (const std::string difference = checkpoint.identity.difference_to(expected, may_differ); !difference.empty())
    refuse("the checkpoint is of another run: " + difference);
  checkpoint.state = body.left();
  return checkpoint;
}

}  // namespace gmis
