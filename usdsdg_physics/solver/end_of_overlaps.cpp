// Return the place of the first box behind the one at `place` that begins where this one has ended.
const float *const key = boxes.data, last = key[boxes.shape[1] + place];
int low = place + 1, high = order.shape[0];
while (low < high) {
    const int middle = (low + high) / 2;
    if (key[middle] < last) low = middle + 1;
    else high = middle;
}
return low;
