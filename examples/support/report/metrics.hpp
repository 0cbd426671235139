#pragma once

#include "support/image/image.hpp"

/// \file
/// How far a picture is from its reference, by four measures. Both pictures are linear RGB of one
/// size.

namespace gmis::tools {

/// The four measures, each over the whole picture.
struct ImageMetrics {
  double relative_error = 0;  ///< √relMSE, as everywhere in this project
  double trimmed = 0;         ///< the same without the worst 0.1 % of the pixels
  double smape = 0;           ///< mean over pixels and channels of |x − ref| / (|x| + |ref| + 0.01): 0 to 1
  double flip = 0;            ///< mean over pixels of ꟻLIP, of the pictures as shown: 0 to 1
};

/// The measures of a picture, and where its errors are.
struct PictureError {
  ImageMetrics metrics;
  Image smape, flip;  ///< `smape_map` and `flip_map`
};

/// `exposure`: the factor with which both pictures are shown; only ꟻLIP depends on it.
[[nodiscard]] PictureError picture_error(const Image& image, const Image& reference, float exposure);

/// |x − ref| / (|x| + |ref| + 0.01), pixel by pixel and channel by channel.
[[nodiscard]] Image smape_map(const Image& image, const Image& reference);

/// ꟻLIP of every pixel, the same number in all three channels: the difference that a person sees
/// who flips between the two pictures on a screen, 67 pixels a degree (0.7 m before a screen that
/// is 0.7 m and 3840 pixels wide). Each picture is shown as value × exposure, cut to [0, 1].
/// [Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild, "ꟻLIP: A Difference Evaluator
/// for Alternating Images", 2020; equations 1 to 13, table 1]
[[nodiscard]] Image flip_map(const Image& image, const Image& reference, float exposure);

}  // namespace gmis::tools
