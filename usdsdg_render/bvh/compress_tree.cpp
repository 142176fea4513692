// Body of compress_tree: nodes of build_tree.cpp as compress.py describes them, on one CPU thread.
//
// Nodes are written level by level, so that the children of each lie together. `write_order` lists the nodes
// to write. Outputs: nodes of 20 words, `order` = items in leaf order, and counts = nodes, items.
{
#pragma clang fp contract(off)
    using wp::uint32;
    using byte = unsigned char;
    constexpr int CHILDREN = 8;
    constexpr double FAR = 1e300;
    // Padding of child boxes relative to the parent's extent and to its position, for the rounding of ray distances: a
    // step of 255 is known to 2^-9.
    constexpr double SLACK = 2e-5, SLACK_OF_PLACE = 1e-6;

    auto min_of = [](double a, double b) { return a < b ? a : b; };
    auto max_of = [](double a, double b) { return a > b ? a : b; };
    auto below = [](float x) {
        const int bits = __builtin_bit_cast(int, x);
        return __builtin_bit_cast(float, x > 0.0f ? bits - 1 : x < 0.0f ? bits + 1 : (int)0x80000001);
    };
    // Exponent of the smallest power of two that is not below a positive number.
    auto exponent_of = [](double x) {
        const long long bits = __builtin_bit_cast(long long, x);
        return (int)(bits >> 52) - 1023 + ((bits & 0xfffffffffffffll) != 0);
    };
    auto power_of_two = [](int exponent) { return __builtin_bit_cast(double, (exponent + 1023ll) << 52); };
    auto byte_of = [](double steps, bool up) {
        if (!(steps < 255.0)) return (byte)255;
        return (byte)((int)steps + (up && (double)(int)steps < steps));
    };

    int* write_order = task.write_order.data;
    int written = 1, items = 0;
    write_order[0] = 0;
    for (int node = 0; node < written; ++node) {
        const float* box = task.nodes.data + (size_t)write_order[node] * 64;
        const int* code = (const int*)(box + 48);
        bool settled[CHILDREN];  // empty children are settled from the start
        int children = 0;
        for (int k = 0; k < CHILDREN; ++k) children += !(settled[k] = !(box[k] <= box[24 + k]));

        // The padded boxes, and that of the node, whose corner is a float.
        double lo[CHILDREN][3], hi[CHILDREN][3], extent[3];
        float corner[3];
        for (int axis = 0; axis < 3; ++axis) {
            const float* lower = box + 8 * axis;
            const float* upper = box + 24 + 8 * axis;
            double first = FAR, last = -FAR;
            for (int k = 0; k < CHILDREN; ++k)
                if (!settled[k]) first = min_of(first, lower[k]), last = max_of(last, upper[k]);
            const double slack = SLACK * (last - first) + SLACK_OF_PLACE * __builtin_fabs(first);
            for (int k = 0; k < CHILDREN; ++k) lo[k][axis] = lower[k] - slack, hi[k][axis] = upper[k] + slack;
            corner[axis] = below((float)(first - slack));
            extent[axis] = last + slack - corner[axis];
        }

        // Greedy assignment of children to slots, best agreement first.
        double agreement[CHILDREN][8];
        for (int k = 0; k < CHILDREN; ++k) {
            double middle[3];
            for (int axis = 0; axis < 3; ++axis)
                middle[axis] = 0.5 * (lo[k][axis] + hi[k][axis]) - (corner[axis] + 0.5 * extent[axis]);
            for (int slot = 0; slot < 8; ++slot)
                agreement[k][slot] = (slot & 4 ? middle[0] : -middle[0]) + (slot & 2 ? middle[1] : -middle[1]) +
                                     (slot & 1 ? middle[2] : -middle[2]);
        }
        int in_slot[8];
        for (int slot = 0; slot < 8; ++slot) in_slot[slot] = -1;
        for (int round = 0; round < children; ++round) {
            int child = -1, chosen = -1;
            for (int k = 0; k < CHILDREN; ++k)
                for (int slot = 0; slot < 8 && !settled[k]; ++slot)
                    if (in_slot[slot] < 0 && (child < 0 || agreement[k][slot] > agreement[child][chosen]))
                        child = k, chosen = slot;
            in_slot[chosen] = child;
            settled[child] = true;
        }

        uint32* words = task.compressed.data + (size_t)node * 20;
        byte* bytes = (byte*)words;
        for (int word = 0; word < 20; ++word) words[word] = 0;
        double steps[3];
        for (int axis = 0; axis < 3; ++axis) {
            words[axis] = __builtin_bit_cast(uint32, corner[axis]);
            const int exponent = exponent_of(max_of(extent[axis], 1e-30) / 255.0);
            bytes[12 + axis] = (byte)(exponent + 127);
            steps[axis] = power_of_two(-exponent);
        }
        words[4] = written;
        words[5] = task.first_item + items;
        int count = 0;  // of the node's own items
        for (int slot = 0; slot < 8; ++slot) {
            const int k = in_slot[slot];
            if (k < 0) continue;
            for (int axis = 0; axis < 3; ++axis) {
                bytes[32 + 8 * axis + slot] = byte_of((lo[k][axis] - corner[axis]) * steps[axis], false);
                bytes[56 + 8 * axis + slot] = byte_of((hi[k][axis] - corner[axis]) * steps[axis], true);
            }
            if (code[k] >= 0) {
                bytes[15] |= 1 << slot;
                bytes[24 + slot] = 32 + 24 + slot;
                write_order[written++] = code[k];
                continue;
            }
            const int first = count;
            if (task.block == 1) {
                task.order.data[task.first_item + items + count++] = ~code[k];
            } else {
                const int* members = task.members.data + (size_t)(~code[k] >> 2) * task.block;
                for (int i = 0; i < task.block && members[i] >= 0; ++i) task.order.data[task.first_item + items + count++] = members[i];
            }
            bytes[24 + slot] = (byte)(((1 << (count - first)) - 1) << 5 | first);
        }
        items += count;
    }
    task.counts.data[0] = written;
    task.counts.data[1] = items;
}
