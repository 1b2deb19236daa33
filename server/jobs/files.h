// Files of renders: written so that they are whole or not there, and where each lies.
#pragma once
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>

namespace alder::jobs {

/// Where a write went wrong for want of space: the disk is full, a quota or a limit on file sizes.
bool is_no_space(int error);

/// Writes to a temporary name in the same folder, syncs, renames, syncs the folder. 0, or errno. `write` is called with the
/// descriptor and returns 0 or errno.
int write_whole(const std::string& path, const std::function<int(int fd)>& write);
int write_whole(const std::string& path, std::string_view bytes);
int write_all(int fd, std::string_view bytes);
int sync_folder(const std::string& folder);

/// DATA/renders/ID: outputs/ (what clients may fetch), checkpoint, log.
struct RenderFolder {
    std::string root;
    RenderFolder(const std::string& data, const std::string& id) : root(data + "/renders/" + id) {}
    std::string outputs() const { return root + "/outputs"; }
    std::string output(const std::string& file) const { return root + "/outputs/" + file; }
    std::string checkpoint() const { return root + "/checkpoint"; }
    std::string log() const { return root + "/log"; }
    /// Makes the folders and removes what a killed process left half written. 0, or errno.
    int prepare() const;
    void remove() const;
};

/// A line of the render's log: time, level, text. Losing the last lines with the power is no harm.
void append_log(const std::string& path, const char* level, std::string_view text);

/// SHA-256 of a file as 64 hexadecimal digits; empty where it cannot be read.
std::string file_digest(const std::string& path);

}  // namespace alder::jobs
