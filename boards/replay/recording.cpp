// A recording of sensors in memory.
#include "recording.hpp"

#include <bit>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

namespace stator::board {

static_assert(std::endian::native == std::endian::little, "values are used as the file has them");

namespace {

struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
};

bool refuse(const char* path, const char* why) {
    std::fprintf(stderr, "error: cannot read the recording '%s': %s\n", path, why);
    return false;
}

}  // namespace

bool Recording::load(const char* path) {
    const std::unique_ptr<std::FILE, Close> file(std::fopen(path, "rb"));
    if (!file || std::fseek(file.get(), 0, SEEK_END) != 0)
        return refuse(path, std::strerror(errno));
    const long bytes = std::ftell(file.get());
    if (bytes < 0) return refuse(path, std::strerror(errno));
    const std::size_t count = static_cast<std::size_t>(bytes) / sizeof(float);
    if (count == 0 || count % kPlanes != 0 ||
        static_cast<std::size_t>(bytes) % sizeof(float) != 0) {
        return refuse(path, "its size is not that of 14 planes of 32-bit numbers");
    }
    values_.resize(count);
    std::rewind(file.get());
    if (std::fread(values_.data(), sizeof(float), count, file.get()) == count) return true;
    return refuse(path, "it ends too early");
}

std::array<float, 3> Recording::xyz(Plane first, std::size_t sample) const {
    const std::size_t n = samples();
    const float* x = values_.data() + static_cast<std::size_t>(first) * n + sample;
    return {x[0], x[n], x[2 * n]};
}

}  // namespace stator::board
