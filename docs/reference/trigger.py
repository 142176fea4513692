# %% setting
import itertools

import usdsdg as rep

boxes = rep.create.cube(count=3, semantics=[("class", "box")])
colors = rep.distribution.uniform((0, 0, 0), (1, 1, 1))

# %% on_frame
with rep.trigger.on_frame(interval=5), boxes:
    rep.randomizer.color(colors=colors)  # a new color every fifth frame

# %% on_time
with rep.trigger.on_time(interval=2.0, max_execs=10), boxes:
    # Bodies begin again from above every two seconds of the timeline.
    rep.modify.pose(position=rep.distribution.uniform((-1, -1, 2), (1, 1, 3)))

# %% on_time_end
last = rep.trigger.on_time_end(interval=2.0)
writer = rep.writers.get("BasicWriter")
writer.initialize(output_dir="ends", rgb=True)
view = rep.create.render_product(rep.create.camera(position=(5, 0, 2), look_at=(0, 0, 0)), (64, 48))
writer.attach(view, trigger=last)  # only the last frame of each two seconds
writer.detach()

# %% on_custom_event
with rep.trigger.on_custom_event("shuffle"), boxes:
    rep.modify.pose(position=rep.distribution.uniform((-1, -1, 0), (1, 1, 1)))
rep.utils.send_og_event("shuffle")


# %% on_condition
captures = itertools.count()


def every_other():
    return next(captures) % 2 == 0


with rep.trigger.on_condition(every_other), boxes:
    rep.randomizer.color(colors=colors)

# %% on_key_press
try:
    rep.trigger.on_key_press("SPACE")
except rep.errors.Unsupported as error:
    print(error)  # there is no window


# %% register
def each_tenth():
    return rep.trigger.on_frame(interval=10)


rep.trigger.register(each_tenth)
with rep.trigger.each_tenth(), boxes:
    rep.randomizer.color(colors=colors)
