// The linker's digest of this program (GNU build id).
#include "server/build_id.h"

#include <elf.h>
#include <link.h>

#include <cstring>

namespace alder {
namespace {

int read_note(dl_phdr_info* info, size_t, void* out) {
    for (int i = 0; i < info->dlpi_phnum; ++i) {
        const auto& header = info->dlpi_phdr[i];
        if (header.p_type != PT_NOTE) continue;
        const char* at = reinterpret_cast<const char*>(info->dlpi_addr + header.p_vaddr);
        const char* end = at + header.p_memsz;
        while (at + sizeof(ElfW(Nhdr)) <= end) {
            ElfW(Nhdr) note;
            std::memcpy(&note, at, sizeof note);
            const char* name = at + sizeof note;
            const char* data = name + ((note.n_namesz + 3) & ~3u);
            if (note.n_type == NT_GNU_BUILD_ID && note.n_namesz == 4 && std::memcmp(name, "GNU", 4) == 0) {
                static constexpr char kDigits[] = "0123456789abcdef";
                auto& text = *static_cast<std::string*>(out);
                for (unsigned k = 0; k < note.n_descsz; ++k) {
                    text.push_back(kDigits[static_cast<unsigned char>(data[k]) >> 4]);
                    text.push_back(kDigits[static_cast<unsigned char>(data[k]) & 15]);
                }
                return 1;
            }
            at = data + ((note.n_descsz + 3) & ~3u);
        }
    }
    return 1;   // the first object is the program itself; libraries do not matter
}

}  // namespace

const std::string& build_id() {
    static const std::string id = [] {
        std::string text;
        dl_iterate_phdr(read_note, &text);
        return text.empty() ? std::string("unknown") : text;
    }();
    return id;
}

}  // namespace alder
