// Answers with what a render has made: files as they are, or shown as PNG and JPEG.
#pragma once
#include <string>

#include "server/http/message.h"
#include "server/jobs/job.h"
#include "server/service.h"

namespace alder::jobs {

/// The file itself: Range, ETag, Content-Digest.
http::Response output_response(Service& s, http::Request& request, const Job& job, const Output& output);
/// As `type`: image/x-exr is the file, image/png and image/jpeg are made of it.
http::Response file_response(Service& s, http::Request& request, const Job& job, const Output& output, const std::string& type);
/// An EXR that changes from request to request.
http::Response snapshot_response(Service& s, http::Request& request, const std::string& path, uint64_t samples, const std::string& type);
/// Of a render that has ended: its one file where `type` is an image's, else the document; a problem where it failed.
http::Response result_response(Service& s, http::Request& request, const Job& job, const std::string& type);

}  // namespace alder::jobs
