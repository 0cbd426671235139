#include "tev.hpp"

#include <bit>
#include <cerrno>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <system_error>
#include <utility>

#include "diagnostics.hpp"

#if __has_include(<sys/socket.h>)
#include <netdb.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/types.h>
#include <unistd.h>
#endif

namespace gmis::tools {

namespace {

/// Bytes of a message, in the order of the protocol.
class Message {
 public:
  explicit Message(std::uint8_t type) : bytes_(4, '\0') { bytes_ += static_cast<char>(type); }
  void add_flag(bool flag) { bytes_ += flag ? '\1' : '\0'; }
  void add_text(std::string_view text) { (bytes_ += text) += '\0'; }
  template <class Number>
  void add(Number number) {
    for (std::size_t i = 0; i < sizeof(Number); ++i) bytes_ += static_cast<char>((number >> (8 * i)) & 0xFF);
  }
  void add_floats(const std::vector<float>& values) {
    bytes_.reserve(bytes_.size() + 4 * values.size());
    for (const float value : values) add(std::bit_cast<std::uint32_t>(value));
  }
  [[nodiscard]] std::string finished() && {
    const auto length = static_cast<std::uint32_t>(bytes_.size());
    for (std::size_t i = 0; i < 4; ++i) bytes_[i] = static_cast<char>((length >> (8 * i)) & 0xFF);
    return std::move(bytes_);
  }

 private:
  std::string bytes_;
};

void add_channels(Message& message) {
  message.add(std::int32_t{3});
  for (const std::string_view channel : {"R", "G", "B"}) message.add_text(channel);
}

}  // namespace

std::string tev_create_message(std::string_view name, int width, int height) {
  Message message(4);
  message.add_flag(true);
  message.add_text(name);
  message.add(std::int32_t{width});
  message.add(std::int32_t{height});
  add_channels(message);
  return std::move(message).finished();
}

std::string tev_update_message(std::string_view name, const Image& image) {
  Message message(6);
  message.add_flag(false);
  message.add_text(name);
  add_channels(message);
  for (const int number : {0, 0, image.width, image.height}) message.add(std::int32_t{number});
  for (const int offset : {0, 1, 2}) message.add(std::int64_t{offset});
  for (int channel = 0; channel < 3; ++channel) message.add(std::int64_t{3});  // floats from pixel to pixel
  message.add_floats(image.rgb);
  return std::move(message).finished();
}

void TevViewer::give_up(const std::string& reason) {
  warning_ = "pictures are not sent to tev at " + address_ + ": " + reason;
#if __has_include(<sys/socket.h>)
  if (socket_ >= 0) ::close(socket_);
#endif
  socket_ = -1;
}

#if __has_include(<sys/socket.h>)

TevViewer::TevViewer(const std::string& address, std::string name) : address_(address), name_(std::move(name)) {
  const std::size_t colon = address.rfind(':');
  if (colon == std::string::npos || colon == 0 || colon + 1 == address.size())
    throw InputError("--tev \"" + address + "\" must be HOST:PORT, such as localhost:14158");
  const std::string host = address.substr(0, colon), port = address.substr(colon + 1);
  unsigned number = 0;
  const char* const end = port.data() + port.size();
  if (const auto [next, error] = std::from_chars(port.data(), end, number);
      error != std::errc{} || next != end || number < 1 || number > 65535)
    throw InputError("--tev \"" + address + "\": the port must be a whole number from 1 to 65535");
  addrinfo wanted{};
  wanted.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (const int error = ::getaddrinfo(host.c_str(), port.c_str(), &wanted, &found); error != 0) {
    give_up(::gai_strerror(error));
    return;
  }
  int reason = 0;
  for (const addrinfo* place = found; place != nullptr && socket_ < 0; place = place->ai_next) {
    socket_ = ::socket(place->ai_family, place->ai_socktype, place->ai_protocol);
    // A viewer that does not answer or read must not hold up the rendering.
    constexpr timeval patience{2, 0};
    if (socket_ >= 0) ::setsockopt(socket_, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
    if (socket_ < 0 || ::connect(socket_, place->ai_addr, place->ai_addrlen) == 0) continue;
    reason = errno;
    ::close(socket_);
    socket_ = -1;
  }
  ::freeaddrinfo(found);
  if (socket_ < 0) give_up(std::strerror(reason == EINPROGRESS ? ETIMEDOUT : reason));
}

TevViewer::~TevViewer() {
  if (socket_ >= 0) ::close(socket_);
}

void TevViewer::send(const std::string& message) {
#ifdef MSG_NOSIGNAL
  constexpr int flags = MSG_NOSIGNAL;  // a viewer that was closed does not end the program
#else
  constexpr int flags = 0;
#endif
  for (std::size_t sent = 0; sent < message.size() && socket_ >= 0;) {
    const auto count = ::send(socket_, message.data() + sent, message.size() - sent, flags);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return give_up(std::strerror(errno));
    sent += static_cast<std::size_t>(count);
  }
}

#else

TevViewer::TevViewer(const std::string& address, std::string name) : address_(address), name_(std::move(name)) {
  give_up("this system has no sockets of POSIX");
}
TevViewer::~TevViewer() = default;
void TevViewer::send(const std::string&) {}

#endif

void TevViewer::show(const Image& image) {
  if (socket_ < 0) return;
  if (!is_created_) send(tev_create_message(name_, image.width, image.height));
  is_created_ = true;
  if (socket_ >= 0) send(tev_update_message(name_, image));
}

}  // namespace gmis::tools
