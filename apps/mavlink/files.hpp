// Files and logs for stations: who is served next.
#pragma once

#include "file_transfer.hpp"
#include "log_transfer.hpp"

namespace stator::apps::mavlink {

// One piece of a file is on its way at a time, and its answer is sent before the next one is asked
// for: both kinds of transfer take turns.
class Files {
  public:
    // False: not a message about files or logs.
    bool handle(Link& link, unsigned number, const mav::Frame& frame, uint64_t now_us) {
        return files_.handle(link, number, frame, now_us) || logs_.handle(link, number, frame);
    }
    // Once in each activation, behind all messages: `lines` are all lines.
    template <class Lines>
    void step(Lines& lines, MavlinkPorts& ports) {
        take_answer(lines, ports);
        FileSource::Wish wish;
        for (unsigned i = 0; i < 2 && source_.is_free(); ++i) {
            is_log_ = !is_log_;
            const bool is_one =
                is_log_ ? logs_.next_wish(lines, wish) : files_.next_wish(lines, wish);
            if (is_one) source_.ask(wish, ports);
        }
        take_answer(lines, ports);  // what the image has is there at once
    }

  private:
    template <class Lines>
    void take_answer(Lines& lines, MavlinkPorts& ports) {
        FilePiece piece{};
        if (!source_.take_answer(ports, piece)) return;
        is_log_ ? logs_.take(lines, piece) : files_.take(lines, piece);
    }

    FileSource source_;
    FileTransfer files_;
    LogTransfer logs_;
    bool is_log_ = false;  // whose turn it is
};

}  // namespace stator::apps::mavlink
