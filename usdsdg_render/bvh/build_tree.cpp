// Body of build_tree: an 8-wide bounding volume hierarchy over boxes, on one CPU thread.
//
// A node is opened by splitting its widest child in two (binned surface area heuristic, costs counted in blocks of
// `block` boxes because a leaf is tested a block at a time) until it has eight. `order` lists the boxes to use and is
// permuted to leaf order. Outputs: nodes of 64 words (lower x y z, upper x y z, eight children, unused),
// `members` = box indices per block, -1 in empty lanes, and counts = nodes, blocks, depth. A child is a node (>= 0), or
// ~(first block << 2 | number of blocks), or with block = 1 ~(box index). Once the remaining depth is
// just enough for a balanced tree, nodes split at the median, which makes `max_depth` a bound.
constexpr int BINS = 16;
constexpr float FAR = 3.0e38f;

struct Box {
    float lo[3], hi[3];
    void clear() {
        for (int k = 0; k < 3; ++k) lo[k] = FAR, hi[k] = -FAR;
    }
    void grow(const float* l, const float* h) {
        for (int k = 0; k < 3; ++k) {
            lo[k] = l[k] < lo[k] ? l[k] : lo[k];
            hi[k] = h[k] > hi[k] ? h[k] : hi[k];
        }
    }
    float area() const {
        const float x = hi[0] - lo[0], y = hi[1] - lo[1], z = hi[2] - lo[2];
        return x < 0 ? 0.0f : x * y + y * z + z * x;
    }
};
struct Range {
    int begin, end;
    Box bounds;
    int size() const { return end - begin; }
};
struct Job {
    Range range;
    int node, depth;
};

const float* lower = task.lowers.data;
const float* upper = task.uppers.data;
int* index = task.order.data;
int* members = task.members.data;
const int block = task.block;
auto bounds_of = [&](int begin, int end) {
    Range r = {begin, end, {}};
    r.bounds.clear();
    for (int i = begin; i < end; ++i) r.bounds.grow(lower + 3 * index[i], upper + 3 * index[i]);
    return r;
};
auto blocks_of = [&](int n) { return (n + block - 1) / block; };
// Levels below a node over n boxes when every node splits evenly.
auto levels = [&](int n) {
    int k = 1;
    for (long long capacity = 8LL * task.leaf_limit; capacity < n; capacity *= 8) ++k;
    return k;
};

auto split_at_median = [&](const Range& r, Range& left, Range& right) {
    const int middle = r.begin + r.size() / 2;
    left = bounds_of(r.begin, middle);
    right = bounds_of(middle, r.end);
};
// Two boxes need no bins: one each, ordered along the first axis in which their centers differ.
auto split_in_two = [&](const Range& r, Range& left, Range& right) {
    int &first = index[r.begin], &second = index[r.begin + 1];
    for (int k = 0; k < 3; ++k) {
        const float a = lower[3 * first + k] + upper[3 * first + k], b = lower[3 * second + k] + upper[3 * second + k];
        if (a == b) continue;
        if (a > b) {
            const int swap = first;
            first = second;
            second = swap;
        }
        break;
    }
    split_at_median(r, left, right);
};
auto split_by_area = [&](const Range& r, Range& left, Range& right) {
    if (r.size() == 2) return split_in_two(r, left, right);
    // Twice the center is used instead of the center.
    float lo[3] = {FAR, FAR, FAR}, hi[3] = {-FAR, -FAR, -FAR};
    for (int i = r.begin; i < r.end; ++i)
        for (int k = 0; k < 3; ++k) {
            const float c = lower[3 * index[i] + k] + upper[3 * index[i] + k];
            lo[k] = c < lo[k] ? c : lo[k];
            hi[k] = c > hi[k] ? c : hi[k];
        }
    float scale[3];
    for (int k = 0; k < 3; ++k) scale[k] = hi[k] > lo[k] ? BINS * 0.99999f / (hi[k] - lo[k]) : 0.0f;
    auto bin_of = [&](int box, int k) {
        const int bin = (int)((lower[3 * box + k] + upper[3 * box + k] - lo[k]) * scale[k]);
        return bin < 0 ? 0 : (bin >= BINS ? BINS - 1 : bin);
    };
    Box bins[3][BINS];
    int count[3][BINS] = {};
    for (int k = 0; k < 3; ++k)
        for (int b = 0; b < BINS; ++b) bins[k][b].clear();
    for (int i = r.begin; i < r.end; ++i) {
        const int box = index[i];
        for (int k = 0; k < 3; ++k) {
            const int b = bin_of(box, k);
            bins[k][b].grow(lower + 3 * box, upper + 3 * box);
            ++count[k][b];
        }
    }
    float best = FAR;
    int axis = -1, cut = 0;
    for (int k = 0; k < 3; ++k) {
        if (scale[k] == 0.0f) continue;
        float right_cost[BINS];
        Box sweep;
        sweep.clear();
        int n = 0;
        for (int b = BINS - 1; b > 0; --b) {
            if (count[k][b]) sweep.grow(bins[k][b].lo, bins[k][b].hi);
            n += count[k][b];
            right_cost[b] = sweep.area() * blocks_of(n);
        }
        sweep.clear();
        n = 0;
        for (int b = 0; b + 1 < BINS; ++b) {
            if (count[k][b]) sweep.grow(bins[k][b].lo, bins[k][b].hi);
            n += count[k][b];
            const float cost = sweep.area() * blocks_of(n) + right_cost[b + 1];
            if (n > 0 && n < r.size() && cost < best) best = cost, axis = k, cut = b;
        }
    }
    if (axis < 0) return split_at_median(r, left, right);  // all centers coincide
    int i = r.begin, j = r.end;
    while (i < j) {
        if (bin_of(index[i], axis) <= cut)
            ++i;
        else {
            const int swap = index[i];
            index[i] = index[--j];
            index[j] = swap;
        }
    }
    left = bounds_of(r.begin, i);
    right = bounds_of(i, r.end);
};

int node_count = 1, block_count = 0, deepest = 0;
const int n = task.count;
auto leaf_code = [&](const Range& r) {
    if (block == 1) return ~index[r.begin];
    const int first = block_count;
    for (int i = r.begin; i < r.end; i += block, ++block_count)
        for (int k = 0; k < block; ++k) members[block_count * block + k] = i + k < r.end ? index[i + k] : -1;
    return ~(first << 2 | (block_count - first));
};

// At most seven siblings are open on each level of the tree.
Job jobs[8 * 64];
int open = 0;
jobs[open++] = {bounds_of(0, n), 0, 1};
while (open) {
    const Job job = jobs[--open];
    deepest = job.depth > deepest ? job.depth : deepest;
    const bool balance = job.depth + levels(job.range.size()) > task.max_depth;
    Range child[8] = {job.range};
    int children = 1;
    while (children < 8) {
        int widest = -1;
        float most = -1.0f;
        for (int k = 0; k < children; ++k) {
            if (child[k].size() <= block) continue;
            const float weight = balance ? (float)child[k].size() : child[k].bounds.area();
            if (weight > most) most = weight, widest = k;
        }
        if (widest < 0) break;
        const Range whole = child[widest];
        if (balance)
            split_at_median(whole, child[widest], child[children]);
        else
            split_by_area(whole, child[widest], child[children]);
        ++children;
    }
    float* box = task.nodes.data + (size_t)job.node * 64;
    int* code = (int*)(box + 48);
    for (int k = 0; k < 8; ++k) {
        Box b;
        b.clear();
        if (k < children) b = child[k].bounds;
        for (int axis = 0; axis < 3; ++axis) {
            box[8 * axis + k] = b.lo[axis];
            box[24 + 8 * axis + k] = b.hi[axis];
        }
        // Empty child: only a NaN ray could hit its inverted box. A leaf without blocks, or the first box again, never the root.
        code[k] = ~0;
        code[8 + k] = 0;
        if (k >= children) continue;
        if (child[k].size() <= task.leaf_limit) {
            code[k] = leaf_code(child[k]);
        } else {
            code[k] = node_count;
            jobs[open++] = {child[k], node_count++, job.depth + 1};
        }
    }
}
task.counts.data[0] = node_count;
task.counts.data[1] = block_count;
task.counts.data[2] = deepest;
