// One end of a link between two machines, as the board and the nodes of the link share it.
//
// The board has the wire: it starts a frame when the sender asks, says when the frame is out, and
// puts in what comes. Sender and receiver may run on two levels or threads: what they share is
// here, and each word has one writer.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "stator/topic.hpp"

namespace stator::machines {

class End {
  public:
    // --- the board ---

    // Starts a frame; the board calls `finish` when it is out. The bytes stay until then.
    using Start = void (*)(void* wire, std::span<const uint8_t> frame);

    // `boot`: another one at each start of this machine, never 0.
    void connect(void* wire, Start begin, uint32_t boot) {
        wire_ = wire;
        start_ = begin;
        boot_ = boot;
    }
    // What comes and finds no room is lost; the frame that it belongs to then fails its check.
    void put(std::span<const uint8_t> bytes) {
        uint32_t head = head_.load();
        for (const uint8_t byte : bytes) {
            if (head - tail_.load() == kRoom) break;
            in_[head % kRoom] = byte;
            ++head;
        }
        head_.store(head);
    }
    void finish() { finished_.store(finished_.load() + 1); }

    // --- the receiver ---

    bool take(uint8_t& byte) {
        const uint32_t tail = tail_.load();
        if (tail == head_.load()) return false;
        byte = in_[tail % kRoom];
        tail_.store(tail + 1);
        return true;
    }
    // The peer's boot number, 0: not heard; the one of ours that it has heard; and whether it has
    // the same graph.
    void note_peer(uint32_t boot, uint32_t heard, bool agrees) {
        peer_boot_.store(boot);
        peer_heard_.store(heard);
        agrees_.store(agrees ? 1 : 0);
    }

    // --- the sender ---

    bool is_idle() const { return started_ == finished_.load(); }
    void start(std::span<const uint8_t> frame) {
        if (start_ == nullptr) return;
        ++started_;
        start_(wire_, frame);
    }
    void note_sent(uint32_t sent, uint32_t replaced) {
        sent_.store(sent);
        replaced_.store(replaced);
    }

    // --- all ---

    uint32_t boot() const { return boot_; }
    uint32_t peer_boot() const { return peer_boot_.load(); }
    // What the peer sends is of this graph.
    bool agrees() const { return agrees_.load() != 0 && peer_boot() != 0; }
    // And it knows who speaks, so that it takes what is sent.
    bool is_up() const { return agrees() && peer_heard_.load() == boot_; }
    uint32_t sent() const { return sent_.load(); }
    uint32_t replaced() const { return replaced_.load(); }

  private:
    static constexpr uint32_t kRoom = 1024;

    void* wire_ = nullptr;
    Start start_ = nullptr;
    uint32_t boot_ = 0;
    uint32_t started_ = 0;
    Shared<uint32_t> finished_;
    std::array<uint8_t, kRoom> in_{};
    Shared<uint32_t> head_;
    Shared<uint32_t> tail_;
    Shared<uint32_t> peer_boot_;
    Shared<uint32_t> peer_heard_;
    Shared<uint32_t> agrees_;
    Shared<uint32_t> sent_;
    Shared<uint32_t> replaced_;
};

}  // namespace stator::machines
