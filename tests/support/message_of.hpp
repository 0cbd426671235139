#pragma once

#include <stdexcept>
#include <string>

namespace gmis_test {

/// The message of the `Error` that `call()` throws; empty when it throws nothing.
template <class Error = std::invalid_argument, class Call>
[[nodiscard]] std::string message_of(const Call& call) {
  try {
    (void)call();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

}  // namespace gmis_test
