// The one function of the image loader module (alder_images.so).
#pragma once
#include <string>

#include "nodes/texture/image_store.h"

/// Reads the file into `image`, or leaves it unreadable and says why. Throws nothing. Thread safe.
extern "C" void alder_load_image(const alder::ImageRequest& request, alder::StoredImage& image, std::string& fault);
