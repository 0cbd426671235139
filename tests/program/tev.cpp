#include "support/tev.hpp"

#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <thread>
#include <vector>

#include "support/catch.hpp"
#include "support/diagnostics.hpp"

// What a viewer would read, decoded by the description of the protocol, at a listener of this test.

using gmis::tools::Image;

namespace {

/// Waits for one connection and reads all that it sends.
class Listener {
 public:
  Listener() : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    REQUIRE(::bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
    REQUIRE(::listen(socket_, 1) == 0);
    socklen_t length = sizeof address;
    REQUIRE(::getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &length) == 0);
    port_ = ntohs(address.sin_port);
  }
  ~Listener() { ::close(socket_); }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  [[nodiscard]] std::string address() const { return "127.0.0.1:" + std::to_string(port_); }
  [[nodiscard]] std::string read_all() const {
    const int connection = ::accept(socket_, nullptr, nullptr);
    std::string bytes;
    std::array<char, 4096> buffer{};
    for (ssize_t count = 0; (count = ::read(connection, buffer.data(), buffer.size())) > 0;)
      bytes.append(buffer.data(), static_cast<std::size_t>(count));
    ::close(connection);
    return bytes;
  }
  /// Takes a connection and ends it.
  void hang_up() const { ::close(::accept(socket_, nullptr, nullptr)); }

 private:
  int socket_;
  int port_ = 0;
};

/// Reads a message from its beginning.
class Reader {
 public:
  explicit Reader(const std::string& bytes, std::size_t begin = 0) : bytes_(bytes), at_(begin) {}
  template <class Number>
  [[nodiscard]] Number number() {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < sizeof(Number); ++i)
      value |= std::uint64_t{static_cast<unsigned char>(bytes_.at(at_++))} << (8 * i);
    return static_cast<Number>(value);
  }
  [[nodiscard]] float real() {
    const auto bits = number<std::uint32_t>();
    float value = 0;
    std::memcpy(&value, &bits, sizeof value);
    return value;
  }
  [[nodiscard]] std::string text() {
    const std::size_t end = bytes_.find('\0', at_);
    const std::string result = bytes_.substr(at_, end - at_);
    at_ = end + 1;
    return result;
  }
  [[nodiscard]] std::size_t place() const { return at_; }

 private:
  const std::string& bytes_;
  std::size_t at_;
};

void check_channels(Reader& reader) {
  CHECK(reader.number<std::int32_t>() == 3);
  for (const char* channel : {"R", "G", "B"}) CHECK(reader.text() == channel);
}

void check_update(Reader& reader, const Image& image) {
  const std::size_t begin = reader.place();
  const auto length = reader.number<std::uint32_t>();
  CHECK(reader.number<std::uint8_t>() == 6);
  CHECK(reader.number<std::uint8_t>() == 0);
  CHECK(reader.text() == "a picture");
  check_channels(reader);
  for (const int wanted : {0, 0, image.width, image.height}) CHECK(reader.number<std::int32_t>() == wanted);
  std::array<std::int64_t, 3> offsets{}, strides{};
  for (auto& offset : offsets) offset = reader.number<std::int64_t>();
  for (auto& stride : strides) stride = reader.number<std::int64_t>();
  std::vector<float> values;
  while (reader.place() < begin + length) values.push_back(reader.real());
  REQUIRE(reader.place() == begin + length);
  REQUIRE(values.size() == image.rgb.size());
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (std::size_t c = 0; c < 3; ++c) {
        const std::int64_t place = offsets[c] + (std::int64_t{y} * image.width + x) * strides[c];
        CHECK(values.at(static_cast<std::size_t>(place)) == image.rgb[image.index(x, y) + c]);
      }
}

}  // namespace

TEST_CASE("a viewer that listens gets the picture as it grows") {
  Image first(5, 3), second(5, 3);
  for (std::size_t i = 0; i < first.rgb.size(); ++i) {
    first.rgb[i] = 0.1F * static_cast<float>(i);
    second.rgb[i] = -1e6F / static_cast<float>(i + 1);
  }
  const Listener listener;
  std::string bytes;
  std::thread reading([&] { bytes = listener.read_all(); });
  {
    gmis::tools::TevViewer viewer(listener.address(), "a picture");
    viewer.show(first);
    viewer.show(second);
    CHECK(viewer.warning().empty());
  }
  reading.join();
  Reader reader(bytes);
  const auto length = reader.number<std::uint32_t>();
  CHECK(reader.number<std::uint8_t>() == 4);
  CHECK(reader.number<std::uint8_t>() == 1);
  CHECK(reader.text() == "a picture");
  CHECK(reader.number<std::int32_t>() == 5);
  CHECK(reader.number<std::int32_t>() == 3);
  check_channels(reader);
  CHECK(reader.place() == length);
  check_update(reader, first);
  check_update(reader, second);
  CHECK(reader.place() == bytes.size());
}

TEST_CASE("a viewer that is not there is a warning, a text that is no address an error") {
  std::string address;
  {
    const Listener listener;  // its port is free again afterwards
    address = listener.address();
  }
  gmis::tools::TevViewer viewer(address, "a picture");
  CHECK(viewer.warning().find(address) != std::string::npos);
  viewer.show(Image(2, 2));
  for (const char* wrong :
       {"localhost", ":14158", "localhost:", "", "localhost:0", "localhost:65536", "localhost:99999", "localhost:http"})
    CHECK_THROWS_AS(gmis::tools::TevViewer(wrong, "a picture"), gmis::tools::InputError);
}

TEST_CASE("a viewer that reads nothing is a warning") {
  const Listener listener;  // accepts no connection: the system alone takes what it has room for
  gmis::tools::TevViewer viewer(listener.address(), "a picture");
  viewer.show(Image(2048, 2048));
  CHECK_FALSE(viewer.warning().empty());
}

TEST_CASE("a viewer that goes away while pictures are sent is a warning") {
  const Listener listener;
  gmis::tools::TevViewer viewer(listener.address(), "a picture");
  listener.hang_up();
  // The first picture after the end of the connection may still be taken by the system.
  for (int i = 0; i < 100 && viewer.warning().empty(); ++i) viewer.show(Image(64, 64));
  CHECK_FALSE(viewer.warning().empty());
}
