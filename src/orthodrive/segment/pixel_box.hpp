#pragma once
// PixelBox lives in geo, because io reads and writes boxes of pixels too.

#include "orthodrive/geo/pixel_box.hpp"
