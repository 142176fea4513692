"""What makes a folder of files a dataset that can be resumed: its recipe, its journal, and its lock.

`recipe` says what a run makes, `journal` which files of which frames are whole, `frames` follows the jobs of frames in
hand, `folders` joins them for each output folder, `portion` says which frames this process makes.
"""
