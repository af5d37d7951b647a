#pragma once
// An array whose copies share what they have in common: copying costs O(1), changing one element
// O(log N) new memory at most, and nothing when no copy shares the path. So particles hold maps that
// differ in a few landmarks, and resampling never copies a map.
//
// A radix tree: leaves of 8 values (landmarks made together are seen together, so they share a leaf),
// inner nodes of 16 children. A node may be changed in place if and only if one array owns it.
//
// Threads may change different arrays at the same time, also arrays that share nodes: a shared node is
// copied, never changed, and who finds himself the only owner sees all that former owners did (the counts
// acquire and release). Which of two arrays copies a node depends on the clock, the values do not.

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <utility>

#include <lcmslam/fastslam/landmarks/node_pool.hpp>

namespace lcmslam {

template <class Value>
class PersistentArray {
 public:
  /// Null when nothing near the index was ever set; default values beside those that were.
  const Value* find(std::size_t index) const {
    if (index >= capacity(depth_)) return nullptr;
    const Node* node = root_.get();
    for (int level = depth_; node && level > 0; --level)
      node = static_cast<const Inner*>(node)->children[digit(index, level)].get();
    return node ? &static_cast<const Leaf*>(node)->values[index % leaf_size] : nullptr;
  }

  /// As find(), and has the memory fetched that reading and edit() will need.
  const Value* prefetch(std::size_t index) const {
    const Value* value = find(index);
    if (!value) return value;
    fetch(value);
    fetch(reinterpret_cast<const char*>(value + 1) - 1);
    fetch(reinterpret_cast<const char*>(value - index % leaf_size) - 1);  // the leaf's count of owners
    return value;
  }

  /// The element for writing; other copies keep theirs.
  Value& edit(std::size_t index) {
    while (index >= capacity(depth_)) grow();
    Pointer* node = &root_;
    for (int level = depth_; level > 0; --level) node = &own<Inner>(*node)->children[digit(index, level)];
    return own<Leaf>(*node)->values[index % leaf_size];
  }

  /// Many elements for writing, as edit(): those that share a leaf find it once. Meanwhile nobody else may
  /// touch this array.
  class Editor {
   public:
    explicit Editor(PersistentArray& array) : array_(array) {}
    Value& operator[](std::size_t index) {
      if (index / leaf_size != leaf_) {
        leaf_ = index / leaf_size;
        first_ = &array_.edit(leaf_ * leaf_size);
      }
      return first_[index % leaf_size];
    }

   private:
    PersistentArray& array_;
    std::size_t leaf_ = ~std::size_t{0};
    Value* first_ = nullptr;
  };

  /// Calls visit(index, before or null, after) for each element in a leaf of `after` that `before` does
  /// not share, ascending. Cost: the changed paths, not the size.
  template <class Visit>
  static void for_each_difference(const PersistentArray& before, const PersistentArray& after, Visit visit) {
    difference(before.root_.get(), before.depth_, after.root_.get(), after.depth_, 0, visit);
  }

  /// Calls visit(index, value) for every element of every leaf, ascending.
  template <class Visit>
  void for_each(Visit visit) const {
    for_each_difference(PersistentArray(), *this,
                        [&](std::size_t i, const Value*, const Value& value) { visit(i, value); });
  }

  /// Calls visit(node's address, its bytes) for every node: what several arrays share has one address.
  template <class Visit>
  void for_each_node(Visit visit) const {
    visit_nodes(root_.get(), depth_, visit);
  }

 private:
  static constexpr std::size_t leaf_size = 8, child_count = 16;

  static void fetch(const void* address) {
#ifdef __GNUC__
    __builtin_prefetch(address);
#else
    static_cast<void>(address);
#endif
  }

  struct Node {
    explicit Node(bool leaf) : is_leaf(leaf) {}
    std::atomic<std::uint32_t> owners{1};
    const bool is_leaf;
  };

  template <class Kind>
  using Pool = NodePool<(sizeof(Kind) + alignof(std::max_align_t) - 1) / alignof(std::max_align_t) *
                        alignof(std::max_align_t)>;

  /// Shares a node.
  class Pointer {
   public:
    Pointer() = default;
    explicit Pointer(Node* node) : node_(node) {}
    Pointer(const Pointer& other) : node_(other.node_) {
      if (node_) node_->owners.fetch_add(1, std::memory_order_relaxed);
    }
    Pointer(Pointer&& other) noexcept : node_(std::exchange(other.node_, nullptr)) {}
    Pointer& operator=(Pointer other) noexcept {
      std::swap(node_, other.node_);
      return *this;
    }
    ~Pointer() {
      if (!node_ || node_->owners.fetch_sub(1, std::memory_order_acq_rel) > 1) return;
      if (node_->is_leaf)
        delete static_cast<Leaf*>(node_);
      else
        delete static_cast<Inner*>(node_);
    }
    explicit operator bool() const { return node_ != nullptr; }
    Node* get() const { return node_; }
    bool alone() const { return node_->owners.load(std::memory_order_acquire) == 1; }

   private:
    Node* node_ = nullptr;
  };

  struct Leaf : Node {
    Leaf() : Node(true) {}
    Leaf(const Leaf& other) : Node(true), values(other.values) {}
    static void* operator new(std::size_t) { return Pool<Leaf>::take(); }
    static void operator delete(void* leaf) { Pool<Leaf>::give_back(leaf); }
    std::array<Value, leaf_size> values{};
  };
  struct Inner : Node {
    Inner() : Node(false) {}
    Inner(const Inner& other) : Node(false), children((other.fetch_children(), other.children)) {}
    ~Inner() { fetch_children(); }
    static void* operator new(std::size_t) { return Pool<Inner>::take(); }
    static void operator delete(void* inner) { Pool<Inner>::give_back(inner); }
    /// Their counts of owners change soon, one after the other: all at once they are fetched sooner.
    void fetch_children() const {
      for (const Pointer& child : children)
        if (child) fetch(child.get());
    }
    std::array<Pointer, child_count> children;
  };

  static constexpr std::size_t capacity(int depth) {
    return leaf_size << (4 * depth);
  }
  static std::size_t digit(std::size_t index, int level) {
    return (index / (leaf_size << (4 * (level - 1)))) % child_count;
  }

  void grow() {
    if (root_) {
      auto* top = new Inner;
      top->children[0] = std::move(root_);
      root_ = Pointer(top);
    }
    ++depth_;
  }

  template <class Kind>
  static Kind* own(Pointer& pointer) {
    if (!pointer)
      pointer = Pointer(new Kind);
    else if (!pointer.alone())
      pointer = Pointer(new Kind(*static_cast<const Kind*>(pointer.get())));
    return static_cast<Kind*>(pointer.get());
  }

  template <class Visit>
  static void difference(const Node* before, int depth_before, const Node* after, int depth_after,
                         std::size_t first, Visit& visit) {
    if (!after || before == after) return;
    if (depth_before > depth_after) {  // the older array was larger: compare with its first part
      const Node* part = before ? static_cast<const Inner*>(before)->children[0].get() : nullptr;
      difference(part, depth_before - 1, after, depth_after, first, visit);
    } else if (depth_after > 0) {
      const bool same_depth = depth_before == depth_after;
      for (std::size_t c = 0; c < child_count; ++c) {
        const Node* part = nullptr;
        if (before && same_depth) part = static_cast<const Inner*>(before)->children[c].get();
        if (before && !same_depth && c == 0) part = before;
        difference(part, same_depth || c > 0 ? depth_after - 1 : depth_before,
                   static_cast<const Inner*>(after)->children[c].get(), depth_after - 1,
                   first + c * capacity(depth_after - 1), visit);
      }
    } else {
      const Leaf* old_leaf = static_cast<const Leaf*>(before);
      for (std::size_t i = 0; i < leaf_size; ++i)
        visit(first + i, old_leaf ? &old_leaf->values[i] : nullptr,
              static_cast<const Leaf*>(after)->values[i]);
    }
  }

  template <class Visit>
  static void visit_nodes(const Node* node, int depth, Visit& visit) {
    if (!node) return;
    visit(static_cast<const void*>(node), depth > 0 ? sizeof(Inner) : sizeof(Leaf));
    if (depth == 0) return;
    for (const Pointer& child : static_cast<const Inner*>(node)->children)
      visit_nodes(child.get(), depth - 1, visit);
  }

  Pointer root_;
  int depth_ = 0;
};

}  // namespace lcmslam
