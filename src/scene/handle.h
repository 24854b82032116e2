#pragma once
// Generational handles and the table that they index. A handle to something that was removed never finds what took its place.
#include <cstdint>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "base/error.h"

namespace parhelion {

// Names one T of a Scene. The default handle names nothing. `index` is dense and stable while the object lives, so tables on the
// device may be indexed by it. Handles that SceneEdit::add returns are *pending*: they are good within that edit, and
// ChangeSet::resolve turns them into lasting ones.
template <class T>
struct Handle {
    static constexpr uint32_t kNoIndex = 0xFFFFFFFFu;
    static constexpr uint32_t kPendingBit = 0x80000000u;  // of `generation`; the bits below then are the edit's serial number

    uint32_t index = kNoIndex;
    uint32_t generation = 0;

    explicit operator bool() const { return index != kNoIndex; }
    bool pending() const { return (generation & kPendingBit) != 0; }
    friend bool operator==(const Handle&, const Handle&) = default;
};

// Objects in numbered slots. Only a Scene changes one; everybody else reads: find, get, and loops over {handle, value}.
template <class T>
class SlotMap {
public:
    struct Item {
        Handle<T> handle;
        const T& value;
    };
    class Iterator {
    public:
        Iterator(const SlotMap* map, uint32_t index) : map_(map), index_(index) { skip_free(); }
        Item operator*() const { return {{index_, map_->slots_[index_].generation}, *map_->slots_[index_].value}; }
        Iterator& operator++() {
            ++index_;
            skip_free();
            return *this;
        }
        friend bool operator==(const Iterator& a, const Iterator& b) { return a.index_ == b.index_; }

    private:
        void skip_free() {
            while (index_ < map_->slots_.size() && !map_->slots_[index_].value) ++index_;
        }
        const SlotMap* map_;
        uint32_t index_;
    };

    Iterator begin() const { return {this, 0}; }
    Iterator end() const { return {this, slot_count()}; }
    size_t size() const { return slots_.size() - free_.size(); }
    bool empty() const { return size() == 0; }
    uint32_t slot_count() const { return static_cast<uint32_t>(slots_.size()); }  // every index is below this

    const T* find(Handle<T> handle) const {
        if (handle.index >= slots_.size()) return nullptr;
        const Slot& slot = slots_[handle.index];
        return slot.value && slot.generation == handle.generation ? &*slot.value : nullptr;
    }
    bool contains(Handle<T> handle) const { return find(handle) != nullptr; }

    // Throws Error for a handle that names nothing (any more).
    const T& get(Handle<T> handle) const {
        const T* found = find(handle);
        if (found == nullptr) fail_stale(handle);
        return *found;
    }

    // The live object in a slot, if there is one.
    std::optional<Handle<T>> handle_at(uint32_t index) const {
        if (index >= slots_.size() || !slots_[index].value) return std::nullopt;
        return Handle<T>{index, slots_[index].generation};
    }

private:
    friend class Scene;
    struct Slot {
        std::optional<T> value;
        uint32_t generation = 1;
    };

    [[noreturn]] static void fail_stale(Handle<T> handle) {
        throw Error(ErrorCode::Failed, fmt::format("stale handle: slot {} generation {} holds nothing", handle.index, handle.generation),
                    std::string(T::kTypeName),
                    handle.pending() ? "handles from SceneEdit::add last after ChangeSet::resolve" : "it was removed");
    }
    T& change(Handle<T> handle) { return const_cast<T&>(get(handle)); }
    Handle<T> insert(T value) {
        if (free_.empty()) {
            slots_.push_back({std::move(value)});
            return {slot_count() - 1, slots_.back().generation};
        }
        const uint32_t index = free_.back();
        free_.pop_back();
        slots_[index].value = std::move(value);
        return {index, slots_[index].generation};
    }
    void erase(Handle<T> handle) {
        Slot& slot = slots_[handle.index];
        slot.value.reset();
        slot.generation = (slot.generation + 1) & ~Handle<T>::kPendingBit;
        free_.push_back(handle.index);
    }

    std::vector<Slot> slots_;
    std::vector<uint32_t> free_;
};

}  // namespace parhelion

template <class T>
struct std::hash<parhelion::Handle<T>> {
    size_t operator()(const parhelion::Handle<T>& h) const noexcept {
        return std::hash<uint64_t>{}(uint64_t(h.generation) << 32 | h.index);
    }
};
