// Logs, as stations list and download them by MAVLink's LOG messages.
#include "log_transfer.hpp"

#include <algorithm>
#include <string_view>

namespace stator::apps::mavlink {

namespace {

template <class Message>
bool is_for(const Message& message, mav::Address own) {
    return (message.target_system == 0 || message.target_system == own.system) &&
           (message.target_component == 0 || message.target_component == own.component);
}

void send_text(Link& link, uint8_t severity, std::string_view words) {
    mav::Statustext text{.severity = severity};
    std::ranges::copy(words.substr(0, text.text.size()), text.text.begin());
    link.send(text);
}

}  // namespace

bool LogTransfer::handle(Link& link, unsigned number, const mav::Frame& frame) {
    Jobs& jobs = jobs_[number];
    switch (frame.id) {
        case mav::LogRequestList::kId: {
            const auto request = mav::decode<mav::LogRequestList>(frame.payload);
            if (!is_for(request, link.own())) return true;
            ++jobs.ticket;
            jobs.is_listing = true;
            jobs.is_last = false;
            jobs.first = jobs.next = request.start;
            jobs.last = request.end;
            return true;
        }
        case mav::LogRequestData::kId: {
            const auto request = mav::decode<mav::LogRequestData>(frame.payload);
            if (!is_for(request, link.own())) return true;
            ++jobs.ticket;
            jobs.is_sending = request.count != 0;
            jobs.knows_end = false;
            jobs.log = request.id;
            jobs.offset = request.ofs;
            jobs.count = request.count;
            return true;
        }
        case mav::LogRequestEnd::kId:
            if (!is_for(mav::decode<mav::LogRequestEnd>(frame.payload), link.own())) return true;
            jobs = {.ticket = static_cast<uint8_t>(jobs.ticket + 1)};
            return true;
        case mav::LogErase::kId:
            if (!is_for(mav::decode<mav::LogErase>(frame.payload), link.own())) return true;
            send_text(link, mav::mav_severity::kWarning, "Logs cannot be erased by MAVLink");
            return true;
        default:
            return false;
    }
}

bool LogTransfer::wants(Jobs& jobs, FileSource::Wish& wish) {
    ticket_ = jobs.ticket;
    is_list_ = jobs.is_listing;
    const auto log_of = [](uint16_t log) { return File{.kind = File::Kind::kLog, .log = log}; };
    if (jobs.is_listing) {
        wish = {log_of(jobs.is_last ? jobs.first : jobs.next)};
        return true;
    }
    if (!jobs.is_sending) return false;
    uint8_t length = kPieceBytes;
    if (jobs.knows_end)
        length = static_cast<uint8_t>(std::min<uint32_t>(length, jobs.end - jobs.offset));
    wish = {log_of(jobs.log), jobs.offset, length};
    return true;
}

void LogTransfer::list(Jobs& jobs, Link& link, const FilePiece& piece) {
    const bool is_there = piece.result == FilePiece::Result::kRead;
    if (!is_there) {
        jobs.is_listing = false;
        if (piece.logs == 0)
            send_text(link, mav::mav_severity::kNotice, "This board cannot read logs");
        if (jobs.next == jobs.first) link.send(mav::LogEntry{.num_logs = piece.logs});
        return;
    }
    link.send(mav::LogEntry{.size = piece.bytes,
                            .id = jobs.is_last ? jobs.first : jobs.next,
                            .num_logs = piece.logs,
                            .last_log_num = static_cast<uint16_t>(piece.logs - 1)});
    if (jobs.is_last) {
        jobs.is_listing = false;
        return;
    }
    jobs.is_last = jobs.next >= jobs.last || jobs.next + 1 >= piece.logs;
    ++jobs.next;
}

void LogTransfer::go_on(Jobs& jobs, Link& link, const FilePiece& piece) {
    const bool is_there = piece.result == FilePiece::Result::kRead;
    if (!jobs.knows_end) {
        const uint32_t left = piece.bytes - std::min(piece.bytes, jobs.offset);
        jobs.knows_end = true;
        jobs.is_to_end = jobs.count > left;
        jobs.end = jobs.offset + std::min(left, jobs.count);
    }
    const uint32_t left = is_there ? std::min<uint32_t>(piece.length, jobs.end - jobs.offset) : 0;
    std::span<const uint8_t> bytes = std::span(piece.data).first(left);
    while (!bytes.empty()) {
        const auto some = bytes.first(std::min<std::size_t>(bytes.size(), kDataBytes));
        send(link, jobs, some);
        jobs.offset += static_cast<uint32_t>(some.size());
        bytes = bytes.subspan(some.size());
    }
    jobs.is_sending = left != 0 && jobs.offset < jobs.end;
    if (jobs.is_sending) return;
    // A message that is not full says that the log ends there; an empty one, if all were full.
    const bool is_last_full = left % kDataBytes == 0;
    if (left == 0 || (jobs.is_to_end && is_last_full)) send(link, jobs, {});
}

void LogTransfer::send(Link& link, const Jobs& jobs, std::span<const uint8_t> data) {
    mav::LogData message{
        .ofs = jobs.offset, .id = jobs.log, .count = static_cast<uint8_t>(data.size())};
    std::ranges::copy(data, message.data.begin());
    link.send(message);
}

}  // namespace stator::apps::mavlink
