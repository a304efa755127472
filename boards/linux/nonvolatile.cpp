// The file of a run in which records outlive it.
#include "nonvolatile.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string_view>

#include "devices.hpp"
#include "stator/host.hpp"

namespace stator::board {

namespace {

// What the file begins with; the number is of the format.
constexpr std::string_view kHead = "stator nonvolatile records 1\n";
static_assert(kHead.size() <= drivers::nonvolatile::file::NonvolatileFile::kHeadBytes);

bool refuse(const char* path, const char* why, const char* hint) {
    std::fprintf(stderr, "error: --nonvolatile '%s': %s\nhint: %s\n", path, why, hint);
    return false;
}

bool has_head(int file) {
    std::array<char, kHead.size()> bytes{};
    return pread(file, bytes.data(), bytes.size(), 0) == static_cast<ssize_t>(bytes.size()) &&
           std::string_view(bytes.data(), bytes.size()) == kHead;
}

// A damaged beginning of a file of the right length costs nothing: each record has a checksum.
bool is_foreign(int file, const struct stat& facts) {
    const bool is_length = facts.st_size == 0 ||
                           facts.st_size == drivers::nonvolatile::file::NonvolatileFile::kFileBytes;
    return !S_ISREG(facts.st_mode) || (!is_length && !has_head(file));
}

// One that is too short has lost its end, which then reads as zeros: as slots without a record.
bool make_whole(int file, const struct stat& facts) {
    if (facts.st_size < drivers::nonvolatile::file::NonvolatileFile::kFileBytes &&
        ftruncate(file, drivers::nonvolatile::file::NonvolatileFile::kFileBytes) != 0) {
        return false;
    }
    return has_head(file) ||
           pwrite(file, kHead.data(), kHead.size(), 0) == static_cast<ssize_t>(kHead.size());
}

}  // namespace

bool open_nonvolatile(const char* path) {
    constexpr mode_t kMode = 0600;  // it may have a key
    const int file = ::open(path, O_RDWR | O_CREAT | O_DSYNC | O_CLOEXEC, kMode);
    struct stat facts {};
    if (file < 0 || fstat(file, &facts) != 0) {
        return refuse(path, std::strerror(errno), "use a file that you may write");
    }
    if (flock(file, LOCK_EX | LOCK_NB) != 0) {
        return refuse(path, "another run uses it", "end that run, or use another file");
    }
    if (is_foreign(file, facts)) {
        return refuse(path, "expected a file of records, found another file",
                      "use another file, or move this one away to begin with an empty one");
    }
    if (!make_whole(file, facts)) {
        return refuse(path, std::strerror(errno), "free disk space, or use another file");
    }
    nonvolatile0.file = file;
    return true;
}

void print_nonvolatile() {
    constexpr std::array kStates{"loading", "loaded", "failed"};
    const NonvolatileStatus& status = nonvolatile0.status;
    std::fprintf(host::facts,
                 "\"nonvolatile\": {\"state\": \"%s\", \"records\": %u, \"most_records\": %u, "
                 "\"mended\": %u, \"damaged\": %u, \"refused\": %u, \"lost\": %u}, ",
                 kStates.at(static_cast<unsigned>(status.state)), status.records,
                 status.most_records, status.mended, status.damaged, status.refused, status.lost);
}

}  // namespace stator::board
