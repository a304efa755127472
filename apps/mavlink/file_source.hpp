// The files of the vehicle: their names, and their bytes.
#pragma once

#include <cstdint>
#include <string_view>

#include "mavlink_ports.hpp"

namespace stator::apps::mavlink {

struct File {
    enum class Kind : uint8_t { kNone, kParameters, kGeneral, kDescribed, kLog };

    Kind kind = Kind::kNone;
    bool with_defaults = false;  // of parameters, and the next two
    uint16_t first = 0;
    uint16_t count = UINT16_MAX;
    uint16_t log = 0;  // which one
};

// The tree that stations see. It has these folders and files and no others, whatever else a board
// may store: a name is compared with the names in a table, and is never a path of a host.
enum class Folder : uint8_t { kNone, kRoot, kParameters, kMetadata, kLogs };

Folder find_folder(std::string_view path);
File find_file(std::string_view path);

// An entry of a folder: a folder or, where `file` is one, a file. Its name; empty: there is none.
struct Entry {
    std::string_view name;
    File file;
};
Entry entry_of(Folder folder, uint32_t index);

// One question at a time is on its way to the node that has the file. The files that describe the
// parameters are constants of the image.
class FileSource {
  public:
    struct Wish {
        File file;
        uint32_t offset = 0;
        uint8_t length = 0;  // 0: its size only
    };

    bool is_free() const { return !is_asked_; }
    void ask(const Wish& wish, MavlinkPorts& ports);
    // The answer to the last wish, once; `piece` has it. One that does not come in time counts
    // as `absent`.
    bool take_answer(MavlinkPorts& ports, FilePiece& piece);

  private:
    static constexpr uint64_t kPatience_us = 500'000;

    bool is_asked_ = false;
    Wish wish_;
    uint8_t tag_ = 0;
    uint64_t asked_us_ = 0;
};

}  // namespace stator::apps::mavlink
