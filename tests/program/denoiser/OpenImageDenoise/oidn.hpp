#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <string>

/// \file
/// The part of Open Image Denoise's interface that `denoised` uses, with a filter whose result
/// shows what it was given: color + 10 albedo + 100 normal, channel by channel.

namespace oidn {

enum class DeviceType { CPU, Default };
enum class Format { Float3 };
enum class Error { None, InvalidOperation };

class FilterRef {
 public:
  explicit FilterRef(std::shared_ptr<std::string> failure) : failure_(std::move(failure)) {}
  void setImage(const char* name, void* data, Format /*format*/, std::size_t width, std::size_t height) {
    images_[name] = {static_cast<float*>(data), width, height};
  }
  void set(const char* name, bool value) { settings_[name] = value; }
  void commit() { is_committed_ = true; }
  void execute() {
    const View output = images_["output"];
    for (const auto& [name, view] : images_)
      if (view.data == nullptr || view.width != output.width || view.height != output.height)
        *failure_ = "sizes differ: " + name;
    if (!is_committed_ || images_.size() != 4 || !settings_["hdr"] || !settings_["cleanAux"])
      *failure_ = "something was not set";
    if (!failure_->empty()) return;
    for (std::size_t i = 0; i < 3 * output.width * output.height; ++i)
      output.data[i] = images_["color"].data[i] + 10 * images_["albedo"].data[i] + 100 * images_["normal"].data[i];
  }

 private:
  struct View {
    float* data = nullptr;
    std::size_t width = 0, height = 0;
  };
  std::shared_ptr<std::string> failure_;
  std::map<std::string, View> images_;
  std::map<std::string, bool> settings_;
  bool is_committed_ = false;
};

class DeviceRef {
 public:
  void commit() {}
  [[nodiscard]] FilterRef newFilter(const char* /*type*/) const { return FilterRef(failure_); }
  [[nodiscard]] Error getError(const char*& message) const {
    if (failure_->empty()) return Error::None;
    message = failure_->c_str();
    return Error::InvalidOperation;
  }

 private:
  std::shared_ptr<std::string> failure_ = std::make_shared<std::string>();
};

inline DeviceRef newDevice(DeviceType /*type*/) {
  return {};
}

}  // namespace oidn
