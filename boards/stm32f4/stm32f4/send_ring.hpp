// A serial line that only sends (RM0090, 30.6), whose bytes wait in a ring until DMA moves them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "stator/one_core_topic.hpp"
#include "stator/registers.hpp"
#include "stm32f4/dma.hpp"

namespace stator::stm32f4 {

// `Bytes` is a DmaBuffer.
template <class Bytes>
class SendRing {
  public:
    constexpr SendRing(uint32_t base, DmaStream stream) : base_(base), stream_(stream) {}

    // At the highest rate, an eighth of the bus's clock, which is on already (30.3.4).
    void start() const {
        stream_.switch_on();
        at(0x0C).write(0);         // USART_CR1
        at(0x08).write(1U << 4);   // USART_BRR
        at(0x14).write(kSendDma);  // USART_CR3
        at(0x0C).write(kEnable | kSend | kEightfold);
    }
    // All bytes or none: false if there is no room for them, or the DMA does not start. One task.
    [[nodiscard]] bool append(std::span<const uint8_t> bytes) {
        const uint32_t end = end_.load();
        if (bytes.size() > Bytes::size() - (end - begin_.load())) return false;
        const size_t place = end % Bytes::size();
        const size_t first = std::min(bytes.size(), Bytes::size() - place);
        copy(bytes.first(first), Bytes::bytes + place);
        copy(bytes.subspan(first), Bytes::bytes);
        end_.store(end + static_cast<uint32_t>(bytes.size()));
        return moving_.load() != 0 || send();
    }
    // The vector of the stream, at its end.
    void finish() {
        stream_.acknowledge();
        begin_.store(begin_.load() + moving_.load());
        moving_.store(0);
        if (begin_.load() != end_.load()) static_cast<void>(send());
    }

  private:
    static constexpr uint32_t kEnable = 1U << 13;
    static constexpr uint32_t kSend = 1U << 3;
    static constexpr uint32_t kEightfold = 1U << 15;
    static constexpr uint32_t kSendDma = 1U << 7;

    Register at(uint32_t offset) const { return Register(base_ + offset); }

    // By words, which need not be aligned on this core: the library's function copies such bytes
    // one by one. That this is a copy is hidden from the compiler, which would call it.
    static void copy(std::span<const uint8_t> from, uint8_t* to) {
        size_t i = 0;
        for (; i + sizeof(uint32_t) <= from.size(); i += sizeof(uint32_t)) {
            uint32_t word;
            std::memcpy(&word, &from[i], sizeof word);
            asm("" : "+r"(word));
            std::memcpy(to + i, &word, sizeof word);
        }
        for (; i < from.size(); ++i) to[i] = from[i];
    }

    // Up to the ring's end at once. Of the vector while something moves, and of the task else.
    bool send() {
        const uint32_t begin = begin_.load();
        const size_t place = begin % Bytes::size();
        const size_t count = std::min<size_t>(end_.load() - begin, Bytes::size() - place);
        moving_.store(static_cast<uint32_t>(count));
        if (stream_.send_once(base_ + 0x04, Bytes::bytes + place, count)) return true;
        moving_.store(0);
        return false;
    }

    uint32_t base_;
    DmaStream stream_;
    Shared<uint32_t> begin_;  // of what waits or moves; counts all bytes, modulo 2^32
    Shared<uint32_t> end_;
    Shared<uint32_t> moving_;  // bytes that DMA has
};

}  // namespace stator::stm32f4
