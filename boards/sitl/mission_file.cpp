// The bytes of a mission, as codegen/stator/mission/model.py writes them.
#include "mission_file.hpp"

#include <bit>
#include <cerrno>
#include <cstdio>
#include <cstring>

namespace stator::board {

static_assert(std::endian::native == std::endian::little);

bool read_mission(const char* path, Mission& mission) {
    std::FILE* const file = std::fopen(path, "rb");
    if (file == nullptr) {
        std::fprintf(stderr, "error: --mission '%s': %s\n", path, std::strerror(errno));
        return false;
    }
    const bool has_all = std::fread(&mission, sizeof mission, 1, file) == 1;
    const bool has_more = std::fgetc(file) != EOF;
    std::fclose(file);
    if (has_all && !has_more) return true;
    std::fprintf(stderr,
                 "error: --mission: expected a file of %zu bytes, found another size: '%s'\n",
                 sizeof mission, path);
    return false;
}

}  // namespace stator::board
