import hypothesis

hypothesis.settings.register_profile("shakedown", deadline=None, derandomize=True, max_examples=25)
hypothesis.settings.load_profile("shakedown")
