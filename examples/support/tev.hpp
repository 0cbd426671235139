#pragma once

#include <string>
#include <string_view>

#include "image/image.hpp"

/// \file
/// Pictures for the viewer tev (github.com/Tom94/tev), by its protocol over TCP, while they are
/// rendered.

namespace gmis::tools {

// The messages, little endian. Each begins with its length in bytes, the four bytes of the length
// included, and its type.

/// "CreateImage" (4): an image of this name with channels R, G and B. The viewer brings it to the
/// front.
[[nodiscard]] std::string tev_create_message(std::string_view name, int width, int height);

/// "UpdateImageV3" (6): all pixels of the image of this name.
[[nodiscard]] std::string tev_update_message(std::string_view name, const Image& image);

/// A connection to a viewer. A viewer that is not there, goes away or reads nothing for two seconds
/// is no error: `warning` then says so, and pictures are no longer sent.
class TevViewer {
 public:
  /// `address`: HOST:PORT. Throws `InputError` for any other text. `name`: of the picture in the
  /// viewer.
  TevViewer(const std::string& address, std::string name);
  ~TevViewer();
  TevViewer(const TevViewer&) = delete;
  TevViewer& operator=(const TevViewer&) = delete;

  /// Sends the picture. The first one decides about the size.
  void show(const Image& image);

  /// Why pictures are not sent; empty while they are.
  [[nodiscard]] const std::string& warning() const noexcept { return warning_; }

 private:
  void send(const std::string& message);
  void give_up(const std::string& reason);

  std::string address_, name_, warning_;
  int socket_ = -1;
  bool is_created_ = false;
};

}  // namespace gmis::tools
