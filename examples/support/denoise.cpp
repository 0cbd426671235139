#include "support/denoise.hpp"

#include <string>

#include "support/diagnostics.hpp"

#if GMIS_HAS_OIDN
#include <OpenImageDenoise/oidn.hpp>
#endif

namespace gmis::tools {

bool has_denoiser() {
  return GMIS_HAS_OIDN != 0;
}

#if GMIS_HAS_OIDN

Image denoised(Image noisy, Image albedo, Image normal) {
  // A device with memory of its own would not see these arrays.
  oidn::DeviceRef device = oidn::newDevice(oidn::DeviceType::CPU);
  device.commit();
  oidn::FilterRef filter = device.newFilter("RT");
  Image smooth(noisy.width, noisy.height);
  const auto pass = [&](const char* name, Image& image) {
    filter.setImage(name, image.rgb.data(), oidn::Format::Float3, static_cast<std::size_t>(image.width),
                    static_cast<std::size_t>(image.height));
  };
  pass("color", noisy);
  pass("albedo", albedo);
  pass("normal", normal);
  pass("output", smooth);
  filter.set("hdr", true);
  filter.set("cleanAux", true);  // albedo and normals have no noise
  filter.commit();
  filter.execute();
  const char* message = nullptr;
  if (device.getError(message) != oidn::Error::None)
    throw OutputError("--denoise: Open Image Denoise says: " + std::string(message != nullptr ? message : "nothing"));
  return smooth;
}

#else

Image denoised(Image /*noisy*/, Image /*albedo*/, Image /*normal*/) {
  throw OutputError("--denoise: this program is built without Open Image Denoise");
}

#endif

}  // namespace gmis::tools
