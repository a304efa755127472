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

constexpr double kLatest_us = 1e15;  // 30 years

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
    const std::size_t count = static_cast<std::size_t>(bytes) / sizeof(Row);
    if (count == 0 || static_cast<std::size_t>(bytes) % sizeof(Row) != 0)
        return refuse(path, "expected rows of 12 64-bit numbers, found another size");
    rows_.resize(count);
    std::rewind(file.get());
    if (std::fread(rows_.data(), sizeof(Row), count, file.get()) != count)
        return refuse(path, "it is incomplete");
    for (std::size_t row = 0; row < count; ++row) {
        const double earliest = row == 0 ? 0.0 : rows_[row - 1].arrival_us;
        if (!(rows_[row].arrival_us >= earliest && rows_[row].arrival_us < kLatest_us))
            return refuse(path, "expected rows in order of time, found another order");
    }
    return true;
}

}  // namespace stator::board
